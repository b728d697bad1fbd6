"""
The medium against a second, slow derivation: from the transmissions of a whole run alone.

Vehicles rest, so that every arrival can be written down at once; each receiver's arrivals are then gone
through in order, without ticks. Bit errors are counted bit by bit, from Eb/N0 = SINR x band / bit rate.
"""

import math
import random
from collections import Counter
from dataclasses import dataclass
from functools import partial
from typing import Any

import pytest

from auv_core.messages import Outcome
from auv_core.params import load
from auv_sim.acoustics.medium import AcousticMedium, MediumConfig
from auv_sim.acoustics.modem import noise_limited
from auv_sim.acoustics.talk import talk
from auv_sim.acoustics.water import transmission_loss_db
from auv_sim.streams import Purpose, uniform

SOUND_MPS, RANGE_M = 1500.0, 900.0
BIT_RATE_BPS, BANDWIDTH_HZ, PREAMBLE_S, BITS = 1500.0, 5000.0, 0.02, 256
MACS = (
    {"kind": "aloha", "params": {"mean_interval_s": 0.7}},
    {"kind": "csma", "params": {"mean_interval_s": 0.4}},
    {"kind": "slotted_aloha", "params": {"slot_s": 0.2, "transmit_prob": 0.3}},
    {"kind": "unlimited"},
)


@dataclass(frozen=True)
class _Arrival:
    start_s: float
    end_s: float
    key: tuple[int, int]
    level: float

    def meets(self, start_s, end_s):
        return min(self.end_s, end_s) - max(self.start_s, start_s) > 1e-7

    def is_at(self, t_s):
        return self.start_s <= t_s + 1e-9 < self.end_s


def _network(draw, capture, has_levels):
    common = {"bit_rate_bps": BIT_RATE_BPS, "preamble_s": PREAMBLE_S, "capture": capture}
    kind, own = (
        ("noise_limited", {"source_level_db": 158.0, "bandwidth_hz": BANDWIDTH_HZ})
        if has_levels
        else ("fixed_rate", {"max_range_m": RANGE_M})
    )
    raw = {
        "fleet_size": draw.randint(2, 7),
        "seed": draw.randint(1, 999),
        "period_s": draw.choice([0.05, 0.1, 0.3]),
        "propagation": {"kind": "straight"},
        "modem": {"kind": kind, "params": {**common, **own}},
        "mac": draw.choice(MACS),
        "outage": {"kind": "none"},
    }
    return load(MediumConfig, raw, "medium")


def _expected(arrivals, own, modem, capture, luck_of):
    """
    Return {key: outcomes that may be} of one receiver.

    `own` are its transmissions, (start, end) in s; `luck_of` gives its random number for a packet.
    """
    locked, lock = set(), None
    for arrival in arrivals:
        t_s = arrival.start_s
        if lock is not None and (lock.end_s <= t_s + 1e-9 or any(lock.start_s < s < t_s for s, _ in own)):
            lock = None
        noise = 1.0 + sum(other.level for other in arrivals if other is not arrival and other.is_at(t_s))
        is_clear = modem is None or modem.acquires(arrival.level / noise)
        if lock is None and is_clear and not any(s <= t_s + 1e-9 < e for s, e in own):
            lock = arrival
            locked.add(arrival)
    found = {}
    for arrival in arrivals:
        certain = _certain(arrival, arrivals, own, modem, capture)
        if certain is None and arrival not in locked:
            certain = Outcome.COLLISION
        if certain is None and modem is None:
            certain = Outcome.DELIVERED
        found[arrival.key] = {certain} if certain else _by_luck(arrival, arrivals, luck_of(arrival.key))
    return found


def _certain(arrival, arrivals, own, modem, capture):
    """Return the outcome of an arrival that needs no luck, as far as it does not depend on locks, or None."""
    if any(arrival.meets(*interval) for interval in own):
        return Outcome.HALF_DUPLEX
    if modem is not None and not modem.acquires(arrival.level):
        return Outcome.NOISE
    rivals = [a for a in arrivals if a is not arrival and a.meets(arrival.start_s, arrival.end_s)]
    heard = [a for a in rivals if modem is None or modem.acquires(a.level)]
    return Outcome.COLLISION if heard and not capture else None


def _by_luck(arrival, arrivals, luck):
    """Return what a random number makes of a packet; two outcomes if it is a close call."""
    others = [a for a in arrivals if a is not arrival]
    quiet, loud = _error_prob(arrival, []), _error_prob(arrival, others)
    return {
        Outcome.NOISE if near < quiet else Outcome.COLLISION if near < loud else Outcome.DELIVERED
        for near in (luck - 0.01, luck, luck + 0.01)
    }


def _error_prob(arrival, others):
    success = 1.0
    for bit in range(BITS):
        t_s = arrival.start_s + PREAMBLE_S + (bit + 0.5) / BIT_RATE_BPS
        sinr = arrival.level / (1.0 + sum(other.level for other in others if other.is_at(t_s)))
        success *= 1.0 - 0.5 * math.erfc(math.sqrt(sinr * BANDWIDTH_HZ / BIT_RATE_BPS))
    return 1.0 - success


def _luck(seed, receiver, key):
    source, sequence = key
    return uniform(seed, Purpose.NOISE, source, receiver, sequence)


@pytest.mark.parametrize("case", range(10))
@pytest.mark.parametrize("capture", [False, True])
@pytest.mark.parametrize("has_levels", [False, True])
def test_every_outcome_follows_from_the_transmissions(case, capture, has_levels):
    draw = random.Random(f"{case} {capture} {has_levels}")
    config = _network(draw, capture, has_levels)
    size_m = draw.choice([100.0, 600.0, 3000.0])
    places = [
        (draw.uniform(0.0, size_m), draw.uniform(0.0, size_m), draw.uniform(0.0, 50.0))
        for _ in range(config.fleet_size)
    ]
    log = talk(AcousticMedium(config), range(round(12.0 / config.period_s)), lambda _tick: places)
    modem = noise_limited.Modem(config.modem.params) if has_levels else None
    sent = [event for event in log if event.outcome is Outcome.SENT]
    seen: Counter[Any] = Counter()
    for receiver in range(1, config.fleet_size + 1):
        expected, arrivals = {}, []
        for event in sent:
            range_m = math.dist(places[event.source - 1], places[receiver - 1])
            key, delay_s = (event.source, event.sequence), range_m / SOUND_MPS
            if event.source == receiver:
                continue
            if modem is None and range_m > RANGE_M:
                expected[key] = {Outcome.RANGE}
                continue
            level = modem.snr_ratio(transmission_loss_db(range_m, 25.0, 1.5)) if modem and has_levels else 0.0
            arrivals.append(_Arrival(event.start_s + delay_s, event.end_s + delay_s, key, level))
        arrivals.sort(key=lambda arrival: (arrival.start_s, arrival.key))
        own = [(event.start_s, event.end_s) for event in sent if event.source == receiver]
        luck_of = partial(_luck, config.seed, receiver)
        expected.update(_expected(arrivals, own, modem, capture, luck_of))
        for event in log:
            if event.outcome is not Outcome.SENT and event.destination == receiver:
                assert event.outcome in expected[event.source, event.sequence], event
                seen[event.outcome] += 1
    assert sum(seen.values()) > 10
