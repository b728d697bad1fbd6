"""The state of a flight according to its clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from auv_bringup.launching.layout import ProcessSpec
from auv_ros.run_config import LOCKSTEP_EPOCH_S
from auv_ros.run_identity import UNKNOWN_EPOCH_S, RunPoint

LOST_STATUS = 3
"""Exit status of a flight, or of its clock's process, after a loss."""


@dataclass(frozen=True)
class Status:
    """The clock's status of the run: the fields of auv_msgs/FlockStatus."""

    state: str
    time_s: float = 0.0
    duration_s: float = 0.0
    epoch_s: float = UNKNOWN_EPOCH_S
    waiting_for: tuple[str, ...] = ()
    lost_vehicles: tuple[str, ...] = ()
    detail: str = ""

    @property
    def point(self) -> RunPoint:
        """The run of this status, and its scenario time."""
        return RunPoint(self.state, self.time_s, self.duration_s, self.epoch_s)


def start_of_run(processes: Sequence[ProcessSpec]) -> RunPoint:
    """Return the known state of a run before the first status: its length, and in lock-step its epoch."""
    (relay,) = (node for process in processes for node in process.nodes if node.role == "relay")
    duration_s = relay.params["duration_ticks"] * relay.params["period_s"]
    epoch_s = LOCKSTEP_EPOCH_S if relay.params["mode"] == "lockstep" else UNKNOWN_EPOCH_S
    return RunPoint("waiting", 0.0, duration_s, epoch_s)
