"""Vehicles whose consensus filters hear each other by packets that come late or not at all, for tests."""

import random
from typing import Any

import numpy as np

from auv_flocking.codec import Layout
from auv_flocking.neighbours.estimates import NeighbourEstimate

STILL = (0.0, 0.0, 0.0)
NOTHING = np.zeros((6, 6))


class Network:
    """
    Filters of a fleet in a TDMA cycle: in every step one vehicle sends, and every other hears it or not.

    `loss_prob` is a number, or a function of (source, destination). With `is_packed`, shared numbers go
    through their fields as they would in a packet.
    """

    def __init__(self, make, positions, *, loss_prob=0.0, seed=0, step_s=1.0, late=0, is_packed=False):
        self.positions = np.array(positions, dtype=float)
        self.filters = [make() for _ in positions]
        self._layouts = [Layout(item.shared_fields) for item in self.filters] if is_packed else None
        self._loss = loss_prob if callable(loss_prob) else lambda _source, _destination: loss_prob
        self._rng = random.Random(seed)
        self._step_s = step_s
        self._late = late
        self._air = []
        self._news: list[dict[int, Any]] = [{} for _ in positions]
        self._count = 0
        self.centres = self.positions.copy()

    def run(self, steps, velocity=STILL, believed=None):
        """
        Let the vehicles move by `velocity` and send in turn; return all errors (steps, n, 3).

        `believed` gives the estimate of the flock's velocity by the index of the vehicle; without it all know
        the true one.
        """
        errors = []
        for _ in range(steps):
            self._step(tuple(velocity), believed or (lambda _index: tuple(velocity)))
            errors.append(self.centres - self.positions.mean(axis=0))
            self.positions = self.positions + self._step_s * np.array(velocity)
            self._count += 1
        return np.array(errors)

    def _step(self, velocity, believed):
        t_s, packet = self._count * self._step_s, None
        for index, item in enumerate(self.filters):
            own = tuple(self.positions[index].tolist())
            heard = [_heard(*news, t_s, velocity) for news in sorted(self._news[index].items())]
            centre = item.centre(own, heard)
            item.advance(own, heard, believed(index), self._step_s)
            self.centres[index] = centre
            if index == self._count % len(self.filters):
                shared = item.shared()
                if self._layouts:
                    shared = tuple(self._layouts[index].unpack(self._layouts[index].pack(shared)))
                packet = (t_s, own, centre, believed(index), shared)
        self._air.append(packet)
        if len(self._air) > self._late:
            self._deliver((self._count - self._late) % len(self.filters), self._air.pop(0))

    def _deliver(self, source, packet):
        for index, news in enumerate(self._news):
            if index != source and self._rng.random() >= self._loss(source, index):
                news[source] = packet


def _heard(source, packet, t_s, velocity):
    time_s, position, centre, flock_velocity, shared = packet
    age_s = t_s - time_s
    position = _carried(position, velocity, age_s)
    return heard_estimate(
        source + 1, position, centre, age_s=age_s, flock_velocity=flock_velocity, time_s=time_s, shared=shared
    )


def _carried(point, rate, age_s):
    return tuple(p + age_s * r for p, r in zip(point, rate, strict=True))


def heard_estimate(address, position, centre, *, age_s=0.0, flock_velocity=STILL, **known):
    """Return the estimate of a neighbour, of which a consensus filter looks at nothing else."""
    return NeighbourEstimate(address, position, STILL, NOTHING, age_s, centre, flock_velocity, **known)
