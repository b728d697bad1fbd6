"""Diagnostics of a vehicle's node on `/diagnostics`."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticStatus

from auv_ros.wire.diagnostics import Status
from auv_sim.command_watch import CommandWatch


def command_status(vehicle_id: str, watch: CommandWatch, malformed: int) -> Status:
    """Return whether a vehicle acts on commands, with the number of malformed messages."""
    return Status(
        level=DiagnosticStatus.ERROR if watch.resting else DiagnosticStatus.OK,
        name=f"{vehicle_id}/vehicle_node: command",
        message=f"the actuators rest: {watch.resting}" if watch.resting else "acts",
        hardware_id=vehicle_id,
        values=[
            ("commands_dropped", str(watch.newest.dropped)),
            ("last_dropped", watch.newest.dropped_words),
            ("messages_malformed", str(malformed)),
        ],
    )
