"""
A formation by displacements: every vehicle keeps its offset from those by which it steers.

    u    = w + w_i' + barrier( limited( g k (p_d - p), u_max ))
    p_d  = w_i + sum_j W_ij (p_j - w_j)        leader: path + w_i
    g    = min(1, phi / A),  A the mean age of the packets of the vehicles j

w is the flock's velocity: the leader's path velocity, passed on as in `communication_aware`, and turned since
its stamp. w_i is the offset of the own slot in the frame that turns with the course of w. W has the reference
type (thesis Section 1.7.2.2; `auv_control.formations.references`).

1. The shape may switch to another at a given time. Vehicles take the slots with the smallest sum of squared
   distances, and their offsets move on a quintic, so that ways stay apart by d / sqrt(2).
2. A vehicle of which no news is younger than `lost_after_s` is lost. The others take the slots of the smaller
   formation. News at second hand count: a report says from whom its sender has heard lately.
3. The lowest live address leads. If it knows the path it follows it. Else it goes on with the flock's last
   velocity, turning as that did: it defines where the formation is.
4. The barrier is that of `communication_aware`. A lost vehicle is an obstacle where it was last heard. A
   vehicle near it steps aside to the right, since a barrier alone would hold one that comes straight at it.

Source: thesis Sections 1.7.2, 1.10.2 to 1.10.4. Deviation: the thesis gives no law for these; feedback on
displacements is Oh, Park and Ahn (2015), A survey of multi-agent formation control. The velocity is the
leader's, passed on, and not that of the vehicles by which one steers: over acoustic links theirs is the most
uncertain part of an estimate, and errors then do not grow along a string.
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.formations.frame import Course, Offset
from auv_control.formations.references import TYPES, reference_weights
from auv_control.formations.shapes import NO_SLOT
from auv_control.formations.targets import Guide, desired_motion
from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.flocking import View
from auv_flocking.flocking._formation import FormationLaw, FormationParams
from auv_flocking.neighbours.estimates import AGE, Estimates


@dataclass(frozen=True)
class Params(FormationParams):
    """The module explains the symbols."""

    leader_share: float = param(
        "share of the leader in the references; the three sum to 1", default=0.5, minimum=0.0, maximum=1.0
    )
    predecessor_share: float = param(
        "share of the predecessor in the references", default=0.5, minimum=0.0, maximum=1.0
    )
    neighbour_share: float = param(
        "share of the neighbours in the shape in the references", default=0.0, minimum=0.0, maximum=1.0
    )

    def __post_init__(self) -> None:
        """Refuse shares that do not sum to 1."""
        super().__post_init__()
        reference_weights(self.shares, (NO_SLOT, 0))

    @property
    def shares(self) -> dict[str, float]:
        """The share of each type of reference."""
        return dict(
            zip(TYPES, (self.leader_share, self.predecessor_share, self.neighbour_share), strict=True)
        )


class Flocking(FormationLaw):
    """The law of one vehicle."""

    def target(
        self, view: View, estimates: Estimates, own: Offset, course: Course
    ) -> tuple[Vec3 | None, float]:
        """
        Return p_d (m; NED) and the mean age of the packets behind it (s).

        Weights of vehicles of which there is no estimate go to the others.
        """
        response_s, order = self._params.response_s, self.roster.order
        if self.leads:
            return self.path_target(view, own), response_s
        weights = order.weights.others[order.slots[self._member.address]]
        known = [
            (float(weights[order.slots[address]]), index, address)
            for index, address in enumerate(estimates.addresses)
            if address in order.slots and weights[order.slots[address]] > 0.0
        ]
        if not known:
            return None, response_s
        total = sum(weight for weight, _, _ in known)
        places, ages_s = estimates.positions(), estimates.column(AGE)
        guides = [
            Guide(weight / total, Offset(places[index]), self.offset(address, course))
            for weight, index, address in known
        ]
        age_s = sum(weight * ages_s[index] for weight, index, _ in known) / total
        wanted = desired_motion(own, guides, uses_accelerations=False)
        return wanted.position, max(age_s, response_s)
