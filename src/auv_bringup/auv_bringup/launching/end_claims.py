"""Claimed ends of a run, until the process of its clock confirms one by ending."""

from __future__ import annotations

from dataclasses import replace

from auv_bringup.launching.flight_status import LOST_STATUS, Status

EXIT_STATUS = {"finished": 0, "aborted": LOST_STATUS}
"""Exit status of the clock's process after each kind of end."""


class EndClaims:
    """
    The recently claimed ends that the process of the clock has not confirmed.

    A clock publishes nothing after an end, and its process then ends. If the run goes on after an end, or
    the process stays, the end came from a foreign process. But the statuses that the run goes on may be
    foreign, too: a contradicted claim is kept until its time is over, and is valid if the process ends
    accordingly.

    Parameters
    ----------
    patience_s : float
        How long the process may take to end (s).

    """

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self._claims: dict[str, tuple[Status, float]] = {}
        self._is_contradicted = False
        self._waited_s = 0.0

    @property
    def are_open(self) -> bool:
        """Whether there is a claim that is neither confirmed nor contradicted."""
        return bool(self._claims) and not self._is_contradicted

    def add(self, claim: Status, wall_s: float) -> None:
        """Take an end, received at `wall_s`; keep the losses that every claim of this end has."""
        if not self.are_open:
            self._waited_s = 0.0
        self._is_contradicted = False
        known, _ = self._claims.get(claim.state, (claim, wall_s))
        lost = tuple(name for name in claim.lost_vehicles if name in known.lost_vehicles)
        self._claims[claim.state] = replace(claim, lost_vehicles=lost), wall_s

    def confirmed_by(self, returncode: int) -> tuple[Status, float] | None:
        """Return the claimed end that fits this exit status, and when it was received."""
        return next(
            (claim for state, claim in self._claims.items() if EXIT_STATUS[state] == returncode), None
        )

    def contradict(self) -> Status:
        """Note that the run goes on; return one of the claims."""
        self._is_contradicted = True
        (claim, _), *_ = self._claims.values()
        return claim

    def time_passed(self, awake_s: float) -> bool:
        """Let `awake_s` of wall time pass (s); return whether the process should have ended by now."""
        self._waited_s += awake_s
        is_over = self._waited_s > self._patience_s
        if is_over and self._is_contradicted:
            self._claims = {}
        return is_over and self.are_open
