"""Selects the command of a vehicle: the newest one, while it is fresh."""

from __future__ import annotations

from auv_core.freshness import Newest, age_limit_s
from auv_core.messages import Command

STALE_COMMAND = "stale command"
BAD_COMMAND = "unusable command"


class CommandWatch:
    """
    Keeps the newest command.

    Attributes
    ----------
    newest
        The newest command, in a tuple: `(None,)` is a command that cannot be used, None means no command.
    resting : str
        Why the actuators rest although the vehicle no longer waits for a command, or an empty text.

    """

    def __init__(self, max_age_s: float, period_s: float) -> None:
        self.newest: Newest[tuple[Command | None]] = Newest(age_limit_s(max_age_s, period_s), period_s)
        self.resting = ""

    def hear(self, command: Command | None, tick: int, now_tick: int) -> None:
        """Take the command of a tick; None means one that cannot be used."""
        self.newest.hear((command,), tick, now_tick)

    def command(self, now_tick: int) -> Command | None:
        """Return the current command, or None if the actuators rest."""
        words = self.newest.why_stale(now_tick)
        if words:
            self.resting = f"{STALE_COMMAND}: {words}"
            return None
        if self.newest.value is None:
            return None
        (command,) = self.newest.value
        self.resting = "" if command is not None else BAD_COMMAND
        return command
