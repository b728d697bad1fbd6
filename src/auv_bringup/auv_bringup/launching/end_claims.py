"""Ends of a run that statuses claim, until the process of its clock confirms one by leaving."""

from __future__ import annotations

from auv_bringup.launching.flight_status import LOST_STATUS, Status

EXIT_STATUS = {"finished": 0, "aborted": LOST_STATUS}
"""With what the process that has the clock leaves after each end."""


class EndClaims:
    """
    The ends claimed and neither confirmed nor refuted.

    A clock says nothing after an end, and its process leaves with it. An end after which the run goes on, or
    the process stays, is somebody else's word.

    Parameters
    ----------
    patience_s : float
        How long the process may take to leave (s).

    """

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self._claims: dict[str, tuple[Status, float]] = {}
        self._waited_s = 0.0

    @property
    def are_open(self) -> bool:
        """Whether there is a claim to be confirmed."""
        return bool(self._claims)

    def add(self, claim: Status, wall_s: float) -> None:
        """Take an end, heard at `wall_s`."""
        if not self._claims:
            self._waited_s = 0.0
        self._claims[claim.state] = claim, wall_s

    def confirmed_by(self, returncode: int) -> tuple[Status, float] | None:
        """Return the end, and when it was heard, after which a process leaves so."""
        return next(
            (claim for state, claim in self._claims.items() if EXIT_STATUS[state] == returncode), None
        )

    def refute(self) -> Status:
        """Drop what is claimed; return one of it."""
        (claim, _), *_ = self._claims.values()
        self._claims = {}
        return claim

    def time_passed(self, awake_s: float) -> bool:
        """Let `awake_s` of wall time pass (s); return whether the process should have left by now."""
        self._waited_s += awake_s
        return self.are_open and self._waited_s > self._patience_s
