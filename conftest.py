"""
An invariant of every test (no modem receives while it transmits), fixtures of several packages, and how tests
with ROS run beside each other (`pytest -n 3`): in domains of their own, and those marked `alone` alone.
"""

import fcntl
import os
import signal
from collections.abc import Generator, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from auv_core.messages import AcousticEvent
from auv_sim.acoustics.event_log import half_duplex_violations
from auv_sim.acoustics.medium import AcousticMedium, MediumConfig
from auv_sim.obstacle_field import ObstacleConfig

# Files that all processes of a test run can lock; none writes into them.
ROOM, DOOR = Path(__file__), Path(__file__).with_name("pyproject.toml")
DOMAINS_EACH = 8
"""ROS domains between those of two processes: a second run beside a test's own takes the next free one."""


def pytest_configure() -> None:
    """Give each process of tests a ROS domain of its own, counted from the given one."""
    worker, domain_id = os.environ.get("PYTEST_XDIST_WORKER", ""), os.environ.get("ROS_DOMAIN_ID")
    if worker and domain_id:
        os.environ["ROS_DOMAIN_ID"] = str(int(domain_id) + DOMAINS_EACH * int(worker.removeprefix("gw")))


@contextmanager
def _locked(file: Path, kind: int) -> Iterator[None]:
    with file.open("rb") as stream:
        fcntl.flock(stream, kind)
        try:
            yield
        finally:
            fcntl.flock(stream, fcntl.LOCK_UN)  # a fork that the test has left may have the file, too


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Keep a test that is marked `alone` apart from the tests of the other processes."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return (yield)
    is_alone = item.get_closest_marker("alone") is not None
    with ExitStack() as stack:
        with ExitStack() as passing:  # one at a time, so that all come through
            passing.enter_context(_locked(DOOR, fcntl.LOCK_EX))
            stack.enter_context(_locked(ROOM, fcntl.LOCK_EX if is_alone else fcntl.LOCK_SH))
        return (yield)


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
