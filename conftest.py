"""An invariant of every test (no modem receives while it transmits), and fixtures of several packages."""

import signal
from collections.abc import Iterator, Sequence

import pytest

from auv_core.messages import AcousticEvent
from auv_sim.acoustics.event_log import half_duplex_violations
from auv_sim.acoustics.medium import AcousticMedium, MediumConfig
from auv_sim.obstacle_field import ObstacleConfig


@pytest.fixture(autouse=True)
def _half_duplex(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Check the acoustic log of every medium that a test makes in its own process."""
    logs: dict[AcousticMedium, list[AcousticEvent]] = {}
    make, take_events = AcousticMedium.__init__, AcousticMedium.take_events

    def made(medium: AcousticMedium, config: MediumConfig, obstacles: Sequence[ObstacleConfig] = ()) -> None:
        make(medium, config, obstacles)
        logs[medium] = []

    def taken(medium: AcousticMedium) -> list[AcousticEvent]:
        events = take_events(medium)
        logs.setdefault(medium, []).extend(events)  # a copy of a medium was not made by `made`
        return events

    monkeypatch.setattr(AcousticMedium, "__init__", made)
    monkeypatch.setattr(AcousticMedium, "take_events", taken)
    yield
    for medium, log in logs.items():
        assert half_duplex_violations([*log, *take_events(medium)]) == []


@pytest.fixture
def keep_signal_handlers() -> Iterator[None]:
    """Restore the signal handlers that a command replaces when it is called in this process."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
