"""Run the neighbour filters of every agent again on a bag's received packets and contacts, and compare.

The inputs are those of the agent only: acoustic packets, sonar contacts and its own navigation. Truth,
simulator and estimates of other agents are not used. What is done with it is :mod:`auv_flocking.senses`, set
as in the scenario beside the bag: any difference means that the recorded estimates used other data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from auv_bag.bag import Bag
from auv_bag.writer import BagError
from auv_core.messages import Packet, SonarContact, VehicleState
from auv_flocking.neighbours.estimates import NeighbourEstimate
from auv_flocking.senses import Senses

TOLERANCE = 1e-9


@dataclass
class Comparison:
    """Largest absolute differences between recorded and repeated estimates.

    Attributes
    ----------
    estimates, ticks
        Number of compared estimates, and of their vehicle ticks.
    position_m, velocity_mps
        Per component, NED.
    covariance
        Over all elements (m^2, m^2/s, m^2/s^2).
    unmatched
        Number of estimates that exist on one side only.
    unused_ticks
        Number of recorded ticks that could not be repeated, since earlier packets are missing in the bag.
    """

    estimates: int = 0
    ticks: int = 0
    position_m: float = 0.0
    velocity_mps: float = 0.0
    covariance: float = 0.0
    unmatched: int = 0
    unused_ticks: int = 0

    @property
    def agrees(self) -> bool:
        """All estimates were matched, at least one was compared, and no difference is above 1e-9."""
        worst = max(self.position_m, self.velocity_mps, self.covariance)
        return self.unmatched == 0 and self.estimates > 0 and worst <= TOLERANCE


def re_estimate(
    bag: Bag, vehicle_ids: Sequence[str], senses: Sequence[Senses], period_s: float
) -> Comparison:
    """Repeat the estimates of all agents.

    Parameters
    ----------
    bag
        The recording.
    vehicle_ids
        Names of the vehicles.
    senses
        The senses of each vehicle, before their first inputs (`auv_flocking.senses.senses_of`).
    period_s
        Control period (s); the estimates of tick k are for k * period_s.
    """
    result = Comparison()
    if "/clock" not in bag.topics:
        raise BagError(
            f"{bag.path}: a real-time bag does not say which packets an "
            "estimate used; allowed: a bag of a lockstep run"
        )
    for vehicle_id, own in zip(vehicle_ids, senses, strict=True):
        _compare_agent(bag, vehicle_id, own, period_s, result)
    return result


def _compare_agent(bag: Bag, vehicle_id: str, senses: Senses, period_s: float, result: Comparison) -> None:
    """Repeat one agent's estimates and add their differences to the result."""
    inboxes = _by_tick(bag, f"/{vehicle_id}/acoustic/rx")
    navs = _by_tick(bag, f"/{vehicle_id}/nav")
    recorded = _by_tick(bag, f"/{vehicle_id}/neighbours")
    known = 0
    while known in inboxes and known in navs:
        known += 1
    result.unused_ticks += sum(tick >= known for tick in recorded)
    for tick in range(known):
        inbox = inboxes[tick]
        packets = [_packet(each.packet) for each in inbox.receptions]
        contacts = [SonarContact(c.range_m, c.bearing_rad, c.elevation_rad) for c in inbox.contacts]
        sensed = senses.take(tick * period_s, _navigation(navs[tick]), packets, contacts)
        if tick in recorded:
            _compare_tick(recorded[tick].neighbours, sensed.neighbours, result)


def _packet(m: Any) -> Packet:
    """Return the record of a decoded packet message."""
    return Packet(m.tick, m.source, m.destination, m.sequence, m.payload.tobytes())


def _navigation(message: Any) -> VehicleState:
    """Return the record of a decoded state message."""
    p, q, v, w = (
        message.pose.position,
        message.pose.orientation,
        message.twist.linear,
        message.twist.angular,
    )
    nu = (v.x, v.y, v.z, w.x, w.y, w.z)
    sds = (message.position_sd_m, message.heading_sd_rad)
    return VehicleState(message.tick, (p.x, p.y, p.z), (q.w, q.x, q.y, q.z), nu, message.valid, *sds)


def _by_tick(bag: Bag, topic: str) -> dict[int, Any]:
    """Return the decoded messages of a topic by their tick."""
    messages = (bag.decode(message) for message in bag.messages({topic}))
    return {message.tick: message for message in messages}


def _compare_tick(recorded: Sequence[Any], repeated: Sequence[NeighbourEstimate], result: Comparison) -> None:
    """Compare the estimates of one agent at one tick."""
    result.ticks += 1
    ours = {estimate.address: estimate for estimate in repeated}
    theirs = {estimate.address: estimate for estimate in recorded}
    result.unmatched += len(ours.keys() ^ theirs.keys())
    for address in ours.keys() & theirs.keys():
        mine, other = ours[address], theirs[address]
        result.estimates += 1
        theirs_m = [other.position.x, other.position.y, other.position.z]
        theirs_mps = [other.velocity.x, other.velocity.y, other.velocity.z]
        result.position_m = max(result.position_m, _difference(mine.position, theirs_m))
        result.velocity_mps = max(result.velocity_mps, _difference(mine.velocity, theirs_mps))
        covariance = np.asarray(mine.covariance).reshape(-1)
        result.covariance = max(result.covariance, _difference(covariance, other.covariance))


def _difference(a: ArrayLike, b: ArrayLike) -> float:
    """Return the largest difference of two elements; infinity for elements that are not numbers."""
    return float(np.nan_to_num(np.abs(np.asarray(a) - np.asarray(b)), nan=np.inf).max())
