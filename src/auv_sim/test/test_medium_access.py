"""Claims about who transmits when, and the effect in the water."""

import math
from collections import Counter, defaultdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import auv_sim.acoustics
from auv_core.messages import Outcome, Packet
from auv_core.params import ConfigError, load, load_section
from auv_sim.acoustics.event_log import half_duplex_violations, in_order
from auv_sim.acoustics.links import DELAY_EDGES_S
from auv_sim.acoustics.mac._poisson import PoissonTimes
from auv_sim.acoustics.medium import MAC, AcousticMedium, MediumConfig
from auv_sim.acoustics.talk import at_rest, talk

MODERATE = settings(max_examples=15, deadline=None)
FIXED = {"kind": "fixed_rate", "params": {"bit_rate_bps": 2000.0, "max_range_m": 1e5}}
NOISY = {"kind": "noise_limited", "params": {"bit_rate_bps": 2000.0, "source_level_db": 165.0}}
CASUAL = [
    {"kind": "aloha", "params": {"mean_interval_s": 0.6}},
    {"kind": "csma", "params": {"mean_interval_s": 0.6}},
    {"kind": "slotted_aloha", "params": {"slot_s": 0.3, "transmit_prob": 0.4}},
]
MACS = [*CASUAL, {"kind": "tdma", "params": {"slot_s": 0.3}}, {"kind": "unlimited"}]


def _medium(**changes):
    raw = {
        "fleet_size": 4, "seed": 5, "period_s": 0.1, "propagation": {"kind": "straight"}, "modem": FIXED,
        "mac": {"kind": "tdma", "params": {"slot_s": 0.3}}, "outage": {"kind": "none"},
    }  # fmt: skip
    return AcousticMedium(load(MediumConfig, {**raw, **changes}, "medium"))


NETWORKS = st.fixed_dictionaries(
    {
        "fleet_size": st.integers(2, 6),
        "seed": st.integers(0, 1000),
        "period_s": st.sampled_from([0.05, 0.1, 0.4]),
        "mac": st.sampled_from(MACS),
        "modem": st.sampled_from([FIXED, NOISY, {"kind": "ideal"}]),
        "outage": st.sampled_from([{"kind": "none"}, {"kind": "bernoulli"}, {"kind": "gilbert_elliott"}]),
        "propagation": st.sampled_from(
            [{"kind": "instant"}, *({"kind": kind} for kind in ("straight", "mackenzie"))]
        ),
    }
)


def staying(places):
    return lambda _tick: places


def _places(seed, count, size_m):
    return [tuple(row) for row in np.random.default_rng(seed).uniform(0.0, size_m, (count, 3)).tolist()]


def _drifting(seed, count, size_m, period_s):
    """Return positions_at for a fleet on random straight courses."""
    starts = _places(seed, count, size_m)
    rates = np.random.default_rng(seed + 1).uniform(-2.0, 2.0, (count, 3)).tolist()

    def positions_at(tick):
        t_s = tick * period_s
        return [
            tuple(x + t_s * v for x, v in zip(start, rate, strict=True))
            for start, rate in zip(starts, rates, strict=True)
        ]

    return positions_at


def _log(network, ticks=80, size_m=300.0, talkers=None):
    medium = _medium(**network)
    positions_at = _drifting(network["seed"], network["fleet_size"], size_m, network["period_s"])
    return medium, talk(medium, range(ticks), positions_at, talkers=talkers)


def _of(events, outcome):
    return [event for event in events if event.outcome is outcome]


@MODERATE
@given(NETWORKS, st.sampled_from([30.0, 1000.0, 20000.0]))
def test_the_log_and_the_counters_agree_and_add_up(network, size_m):
    medium, events = _log(network, size_m=size_m)
    sent = Counter(event.source for event in _of(events, Outcome.SENT))
    ends = Counter((e.source, e.destination, e.outcome) for e in events if e.outcome is not Outcome.SENT)
    for (source, destination), link in medium.links.items():
        found = [ends[source, destination, outcome] for outcome in Outcome if outcome is not Outcome.SENT]
        assert found == [
            link.delivered, link.lost_range, link.lost_noise, link.lost_collision, link.lost_half_duplex,
            link.lost_outage,
        ]  # fmt: skip
        in_flight = sent[source] - sum(found)
        assert link.sent == sent[source] == link.delivered + link.lost + in_flight
        assert in_flight >= 0
        assert size_m > 1000.0 or in_flight <= 2 + 1.8 / network["period_s"]
        assert link.bytes_sent == 32 * link.sent
        assert sum(link.delay_counts) == link.delivered


@MODERATE
@given(NETWORKS)
def test_no_modem_hears_while_it_transmits_nor_sends_two_packets_at_once(network):
    _, events = _log(network)
    assert half_duplex_violations(events) == []
    on_air = defaultdict(list)
    for event in _of(events, Outcome.SENT):
        on_air[event.source].append(event)
    for own in on_air.values():
        assert all(before.end_s <= after.start_s + 1e-7 for before, after in pairwise(own))
        assert [event.sequence for event in own] == sorted(event.sequence for event in own)


@MODERATE
@given(NETWORKS)
def test_every_packet_has_one_end_at_every_receiver_at_its_speed(network):
    _, events = _log(network)
    sent = {(event.source, event.sequence): event for event in _of(events, Outcome.SENT)}
    seen = set()
    for event in events:
        if event.outcome is Outcome.SENT:
            continue
        key = (event.source, event.sequence, event.destination)
        assert key not in seen
        seen.add(key)
        own = sent[event.source, event.sequence]
        delays_s = (event.start_s - own.start_s, event.end_s - own.end_s)
        assert min(delays_s) >= -1e-9
        assert delays_s[0] == pytest.approx(delays_s[1], abs=0.01)
        assert network["propagation"]["kind"] != "instant" or max(delays_s) == pytest.approx(0.0, abs=1e-9)


@MODERATE
@given(NETWORKS)
def test_the_same_calls_give_the_same_log_whether_packets_come_together_or_one_by_one(network):
    _, together = _log(network, ticks=60)
    medium = _medium(**network)
    events: list[Any] = []
    sequences: Counter[int] = Counter()
    positions_at = _drifting(network["seed"], network["fleet_size"], 300.0, network["period_s"])
    for tick in range(60):
        states = at_rest(tick, positions_at(tick))
        ready = [inbox.transmit_ready for inbox in medium.exchange(tick, states)]
        for address in range(1, network["fleet_size"] + 1):
            if ready[address - 1]:
                sequences[address] += 1
                packet = Packet(tick, address, 0, sequences[address], bytes(32))
                medium.transmit({address: [packet]}, states)
        taken = medium.take_events()
        assert taken == in_order(reversed(taken))
        events += taken
    assert repr(events) == repr(together)


@pytest.mark.parametrize("mac", [*CASUAL, {"kind": "tdma"}])
@pytest.mark.parametrize("modem", [FIXED, NOISY])
def test_a_silent_or_distant_vehicle_does_not_change_the_others_luck(mac, modem):
    outage = {"kind": "gilbert_elliott"}
    near = [(0.0, 0.0, 5.0), (1400.0, 0.0, 5.0), (0.0, 900.0, 5.0)]
    logs = []
    for others in ([], [(1e7, 0.0, 5.0)], [(500.0, 0.0, 5.0)] * 3):
        if mac["kind"] == "tdma" and others:
            continue
        places = near + others
        medium = _medium(fleet_size=len(places), mac=mac, modem=modem, outage=outage)
        talkers = {1, 2, 3} if others != [(1e7, 0.0, 5.0)] else {1, 2, 3, 4}
        events = talk(medium, range(600), staying(places), talkers=talkers)
        logs.append([event for event in events if max(event.source, event.destination) <= 3])
    assert len({repr(log) for log in logs}) == 1
    assert len(logs[0]) > 50


@MODERATE
@given(
    st.integers(2, 8),
    st.integers(0, 1000),
    st.sampled_from([0.1, 0.25]),
    st.sampled_from([FIXED, NOISY]),
)
def test_tdma_never_collides_while_the_guard_covers_the_longest_travel(fleet_size, seed, period_s, modem):
    # 128 ms on the air, and 172 ms for 258 m.
    medium = _medium(fleet_size=fleet_size, seed=seed, period_s=period_s, modem=modem)
    size_m = 250.0 / math.sqrt(3.0)
    places = _places(seed, fleet_size, size_m)
    events = talk(medium, range(round(15.0 / period_s)), lambda _tick: places)
    outcomes = Counter(event.outcome for event in events)
    assert outcomes[Outcome.DELIVERED] > 0
    assert set(outcomes) == {Outcome.SENT, Outcome.DELIVERED}


def test_tdma_collides_where_the_guard_is_too_short():
    places = [(0.0, 0.0, 5.0), (0.0, 600.0, 5.0), (0.0, 300.0, 5.0), (0.0, 0.0, 8.0)]
    events = talk(_medium(), range(200), lambda _tick: places)
    assert _of(events, Outcome.HALF_DUPLEX)
    assert _of(events, Outcome.COLLISION)


@pytest.mark.parametrize(
    ("sources", "load"),
    [(4, 1.0), *(pytest.param(*case, marks=pytest.mark.slow) for case in ((4, 0.5), (8, 1.0), (8, 2.0)))],
)
def test_the_throughput_of_slotted_aloha_is_the_textbooks(sources, load):
    """One listener, no capture, travel times inside the slot: S = G (1 - G / N)^(N - 1)."""
    slots, slot_s = 8000, 0.2
    mac = {"kind": "slotted_aloha", "params": {"slot_s": slot_s, "transmit_prob": load / sources}}
    medium = _medium(fleet_size=sources + 1, mac=mac, period_s=slot_s, seed=3)
    places = [(5.0 * i, 0.0, 5.0) for i in range(sources + 1)]
    talk(medium, range(slots), lambda _tick: places, talkers=range(1, sources + 1))
    heard = sum(medium.links[source, sources + 1].delivered for source in range(1, sources + 1))
    expected = load * (1.0 - load / sources) ** (sources - 1)
    assert heard / slots == pytest.approx(expected, rel=0.03)


def test_unslotted_aloha_collides_over_twice_the_airtime():
    """A packet survives when each other source is silent at its start, and for one airtime from then on."""
    sources, interval_s, airtime_s = 12, 3.84, 0.128
    mac = {"kind": "aloha", "params": {"mean_interval_s": interval_s}}
    medium = _medium(fleet_size=sources + 1, mac=mac, propagation={"kind": "instant"})
    talk(medium, range(6000), lambda _tick: [(0.0, 0.0, 5.0)] * (sources + 1), talkers=range(1, sources + 1))
    links = [medium.links[source, sources + 1] for source in range(1, sources + 1)]
    share = sum(link.delivered for link in links) / sum(link.sent for link in links)
    # A source that is on the air does not wish: its times are airtime and interval apart on average.
    is_silent = 1.0 - airtime_s / (interval_s + airtime_s)
    expected = (is_silent * math.exp(-airtime_s / interval_s)) ** (sources - 1)
    # Collisions come in pairs: about 1800 packets are as good as 900, of which this is three deviations.
    assert share == pytest.approx(expected, abs=0.05)


def test_a_modem_that_listens_does_not_begin_while_it_hears():
    mac = {"kind": "csma", "params": {"mean_interval_s": 0.5}}
    medium = _medium(fleet_size=5, mac=mac)
    places = _places(2, 5, 150.0)
    events = talk(medium, range(2000), lambda _tick: places)
    begun = _of(events, Outcome.SENT)
    assert len(begun) > 300
    heard = defaultdict(list)
    for event in events:
        if event.outcome is not Outcome.SENT:
            heard[event.destination].append((event.start_s, event.end_s))
    for event in begun:
        assert not any(start_s <= event.start_s < end_s for start_s, end_s in heard[event.source])


def test_listening_first_loses_less_in_a_small_fleet_and_more_than_nothing():
    places = _places(2, 5, 60.0)

    def lost(kind):
        mac = {"kind": kind, "params": {"mean_interval_s": 1.0}}
        medium = _medium(fleet_size=5, mac=mac)
        talk(medium, range(2500), lambda _tick: places)
        links = medium.links.values()
        return sum(link.lost for link in links) / sum(link.sent for link in links)

    assert 0.0 < lost("csma") < 0.5 * lost("aloha")


def test_a_modem_that_waits_does_not_ask_and_sends_what_it_holds():
    mac = {"kind": "csma", "params": {"mean_interval_s": 0.2, "min_backoff_s": 0.3, "max_backoff_s": 0.3}}
    slow = {"kind": "fixed_rate", "params": {"bit_rate_bps": 100.0}}
    medium = _medium(fleet_size=2, mac=mac, modem=slow)
    events = talk(medium, range(2000), lambda _tick: [(0.0, 0.0, 5.0), (30.0, 0.0, 5.0)])
    for source in (1, 2):
        sequences = [event.sequence for event in _of(events, Outcome.SENT) if event.source == source]
        assert sequences == list(range(1, len(sequences) + 1))
        assert len(sequences) > 20


def test_what_comes_late_starts_when_it_comes():
    medium = _medium(mac={"kind": "unlimited"})
    states = at_rest(0, [(0.0, 0.0, 5.0)] * 4)
    for tick in range(4):
        medium.exchange(tick, states)
    medium.transmit({1: [Packet(1, 1, 0, 1, bytes(32))]}, states)
    (event,) = medium.take_events()
    assert event.start_s == pytest.approx(0.3)


def test_a_modem_that_is_on_the_air_refuses_another_packet():
    medium = _medium(mac={"kind": "unlimited"})
    states = at_rest(0, [(0.0, 0.0, 5.0)] * 4)
    medium.exchange(0, states)
    medium.transmit({1: [Packet(0, 1, 0, 1, bytes(32))]}, states)
    assert not medium.exchange(1, states)[0].transmit_ready
    with pytest.raises(
        ValueError, match="modem 1 was handed a packet in tick 1, in which it still has another"
    ):
        medium.transmit({1: [Packet(1, 1, 0, 2, bytes(32))]}, states)


def test_delays_are_counted_from_the_start_of_a_transmission_to_the_end_of_its_reception():
    medium = _medium(fleet_size=2, mac={"kind": "tdma", "params": {"slot_s": 1.0}})
    talk(medium, range(200), lambda _tick: [(0.0, 0.0, 5.0), (300.0, 0.0, 5.0)])
    link = medium.links[1, 2]
    assert link.delay_counts[DELAY_EDGES_S.index(0.2) + 1] == link.delivered == 10


@pytest.mark.parametrize(
    ("preset", "guarded_m"),
    [
        ("lossy", 298.0), ("fast", 131.0), ("micromodem_fsk", 2250.0), ("micromodem_psk", 1050.0),
        ("micromodem_fdp", 621.0), ("evologics_s2c", 506.0),
    ],
)  # fmt: skip
def test_the_slots_of_the_presets_hold_a_report_and_guard_what_they_say(preset, guarded_m):
    path = Path(auv_sim.acoustics.__file__).parent / "presets" / f"{preset}.yaml"
    sections = {**yaml.safe_load(path.read_text(encoding="utf-8")), "outage": {"kind": "none"}}
    places = [(0.0, 0.0, 5.0), (0.0, guarded_m - 2.0, 5.0), (0.0, 0.5 * guarded_m, 5.0), (0.0, 10.0, 5.0)]
    medium = _medium(**sections)
    medium.check_payload(32)
    outcomes = {event.outcome for event in talk(medium, range(800), lambda _tick: places)}
    assert outcomes == {Outcome.SENT, Outcome.DELIVERED}
    places[1] = (0.0, guarded_m + 6.0, 5.0)
    outcomes = {event.outcome for event in talk(_medium(**sections), range(800), lambda _tick: places)}
    assert outcomes & {Outcome.HALF_DUPLEX, Outcome.COLLISION}


def test_a_violation_in_a_log_is_found():
    medium = _medium(fleet_size=2, mac={"kind": "tdma", "params": {"slot_s": 1.0}})
    events = talk(medium, range(50), lambda _tick: [(0.0, 0.0, 5.0), (300.0, 0.0, 5.0)])
    assert half_duplex_violations(events) == []
    reception = _of(events, Outcome.DELIVERED)[2]
    kinds = (Outcome.SENT, reception.destination, 0, 99)
    for shift_s, is_one in ((0.0, True), (0.05, True), (-0.05, True), (0.2, False), (-0.2, False)):
        own = type(reception)(
            *kinds, reception.start_s + shift_s, reception.end_s + shift_s, math.nan, 32
        )  # fmt: skip
        assert (len(half_duplex_violations([*events, own])) == 1) is is_one


def test_poisson_times_have_their_rate_and_do_not_depend_on_the_questions():
    times = PoissonTimes(2.0, 7)
    ticks = [(address, tick) for address in (1, 2) for tick in range(10000)]
    forward = [times.first_s(address, 0.1 * tick, 0.1 * (tick + 1)) for address, tick in ticks]
    again = PoissonTimes(2.0, 7)
    backward = [again.first_s(address, 0.1 * tick, 0.1 * (tick + 1)) for address, tick in reversed(ticks)]
    assert backward[::-1] == forward
    share = sum(time_s is not None for time_s in forward) / len(forward)
    assert share == pytest.approx(1.0 - math.exp(-0.05), rel=0.06)


def test_waits_that_cannot_be_are_refused():
    with pytest.raises(
        ConfigError, match=r"^x\.params\.max_backoff_s: 0\.5 is not allowed; allowed: at least"
    ):
        load_section({"kind": "csma", "params": {"min_backoff_s": 0.7}}, "x", MAC)
