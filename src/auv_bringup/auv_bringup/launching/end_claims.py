"""Ends of a run that statuses claim, until the process of its clock confirms one by leaving."""

from __future__ import annotations

from dataclasses import replace

from auv_bringup.launching.flight_status import LOST_STATUS, Status

EXIT_STATUS = {"finished": 0, "aborted": LOST_STATUS}
"""With what the process that has the clock leaves after each end."""


class EndClaims:
    """
    The ends claimed of late that the process of the clock has not confirmed.

    A clock says nothing after an end, and its process leaves with it. An end after which the run goes on, or
    the process stays, is somebody else's word. So may be the words that the run goes on: a claim that they
    contradict is kept until its time is over, and holds if the process leaves with it.

    Parameters
    ----------
    patience_s : float
        How long the process may take to leave (s).

    """

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self._claims: dict[str, tuple[Status, float]] = {}
        self._is_contradicted = False
        self._waited_s = 0.0

    @property
    def are_open(self) -> bool:
        """Whether there is a claim to be confirmed that nothing contradicts."""
        return bool(self._claims) and not self._is_contradicted

    def add(self, claim: Status, wall_s: float) -> None:
        """Take an end, heard at `wall_s`; of its losses those that every claim of this end has."""
        if not self.are_open:
            self._waited_s = 0.0
        self._is_contradicted = False
        known, _ = self._claims.get(claim.state, (claim, wall_s))
        lost = tuple(name for name in claim.lost_vehicles if name in known.lost_vehicles)
        self._claims[claim.state] = replace(claim, lost_vehicles=lost), wall_s

    def confirmed_by(self, returncode: int) -> tuple[Status, float] | None:
        """Return the end, and when it was heard, after which a process leaves so."""
        return next(
            (claim for state, claim in self._claims.items() if EXIT_STATUS[state] == returncode), None
        )

    def contradict(self) -> Status:
        """Take note that the run goes on; return one of the claims."""
        self._is_contradicted = True
        (claim, _), *_ = self._claims.values()
        return claim

    def time_passed(self, awake_s: float) -> bool:
        """Let `awake_s` of wall time pass (s); return whether the process should have left by now."""
        self._waited_s += awake_s
        is_over = self._waited_s > self._patience_s
        if is_over and self._is_contradicted:
            self._claims = {}
        return is_over and self.are_open
