"""What holds in every test: no modem hears while it transmits."""

import pytest

from auv_sim.acoustics.event_log import half_duplex_violations
from auv_sim.acoustics.medium import AcousticMedium


@pytest.fixture(autouse=True)
def _half_duplex(monkeypatch):
    """Search the acoustic log of every medium that a test makes in its own process."""
    logs = {}
    make, take_events = AcousticMedium.__init__, AcousticMedium.take_events

    def made(medium, config):
        make(medium, config)
        logs[medium] = []

    def taken(medium):
        events = take_events(medium)
        logs[medium] += events
        return events

    monkeypatch.setattr(AcousticMedium, "__init__", made)
    monkeypatch.setattr(AcousticMedium, "take_events", taken)
    yield
    for medium, log in logs.items():
        assert half_duplex_violations([*log, *take_events(medium)]) == []
