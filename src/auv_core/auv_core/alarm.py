"""Logs one line when a problem begins or changes, and one when it ends."""

from __future__ import annotations

from typing import Any

_REPEAT_S = 1.0


class Alarm:
    """
    Logs the changes of one kind of problem of a node.

    Parameters
    ----------
    logger : rclpy logger
        Logger of the node.
    begins, ends : str
        Texts before the description when the problem begins and when it ends.

    """

    def __init__(self, logger: Any, begins: str, ends: str) -> None:
        self._logger = logger
        self._begins = begins
        self._ends = ends
        self._kind: object = None
        self._words = ""
        self._since_s = 0.0

    def note(self, kind: object, words: str, t_s: float) -> bool:
        """
        Note the state at `t_s` (s); return whether it has changed.

        Parameters
        ----------
        kind : object
            The problem; a false value if there is none.
        words : str
            Description of the problem.
        t_s : float
            Scenario time (s).

        """
        if (kind or None) == self._kind:
            return False
        if kind:
            self._logger.error(f"{self._begins}: {words}", throttle_duration_sec=_REPEAT_S)
            if not self._kind:
                self._since_s = t_s
            self._words = words
        else:
            for_s = t_s - self._since_s
            self._logger.info(
                f"{self._ends} after {for_s:.1f} s; it was: {self._words}", throttle_duration_sec=_REPEAT_S
            )
        self._kind = kind or None
        return True
