"""Claims about the acoustic medium: causality, losses, order, counters."""

import math
from collections import Counter
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from auv_core.messages import Packet, VehicleState
from auv_core.params import load
from auv_sim.acoustics.medium import AcousticMedium, MediumConfig

MODERATE = settings(max_examples=40, deadline=None)


def _config(**changes):
    raw = {
        "fleet_size": 4,
        "seed": 5,
        "period_s": 0.1,
        "propagation": {"kind": "straight"},
        "modem": {"kind": "fixed_rate", "params": {"max_range_m": 300.0}},
        "mac": {"kind": "tdma"},
        "outage": {"kind": "bernoulli"},
    }
    return load(MediumConfig, {**raw, **changes}, "medium")


def _ideal(**changes):
    kinds = {"propagation": "instant", "modem": "ideal", "mac": "unlimited", "outage": "none"}
    return _config(**{**{key: {"kind": kind} for key, kind in kinds.items()}, **changes})


def _states(tick, positions):
    return [VehicleState(tick, position, (1.0, 0.0, 0.0, 0.0), (0.0,) * 6) for position in positions]


def _line(count, spacing_m=50.0):
    return [(spacing_m * i, 0.0, 10.0) for i in range(count)]


def test_nothing_that_begins_to_arrive_in_a_silence_is_delivered():
    silent = AcousticMedium(_ideal(silence={"from_s": 1.0, "until_s": 2.0}))
    _, receptions = _chatter(silent, 40, lambda tick: _line(4))
    at_s = [reception.packet.tick * 0.1 for _, _, reception in receptions]
    assert at_s
    assert not [t_s for t_s in at_s if 1.0 <= t_s < 2.0]
    assert {round(10.0 * t_s) for t_s in at_s} >= {9, 20}
    lost = {link: counters.lost_outage for link, counters in silent.links.items()}
    assert set(lost.values()) == {10}


def _chatter(medium, ticks, positions_at, *, size=40, talkers=None):
    """
    Let all modems transmit whenever they ask; return the sent and the received packets.

    Returns (packets, receptions); receptions are (tick, address, Reception).
    """
    packets: list[Packet] = []
    receptions: list[Any] = []
    sequences: Counter[int] = Counter()
    for tick in range(ticks):
        states = _states(tick, positions_at(tick))
        handed_over = {}
        for address, inbox in enumerate(medium.exchange(tick, states), start=1):
            assert inbox.tick == tick
            receptions += [(tick, address, reception) for reception in inbox.receptions]
            if inbox.transmit_ready and (talkers is None or address in talkers):
                sequences[address] += 1
                handed_over[address] = [Packet(tick, address, 0, sequences[address], bytes([address] * size))]
        medium.transmit(handed_over, states)
        packets += [packet for (packet,) in handed_over.values()]
    return packets, receptions


def _key(packet, address):
    return (packet.source, address, packet.sequence)


NETWORKS = st.fixed_dictionaries(
    {
        "fleet_size": st.integers(1, 6),
        "seed": st.integers(0, 1000),
        "period_s": st.sampled_from([0.05, 0.1, 0.25, 0.4]),
        "mac": st.sampled_from(
            [{"kind": "unlimited"}, *({"kind": "tdma", "params": {"slot_s": s}} for s in (0.1, 0.25, 0.7))]
        ),
        "outage": st.sampled_from([{"kind": "none"}, {"kind": "bernoulli", "params": {"loss_prob": 0.4}}]),
        "propagation": st.sampled_from(
            [
                {"kind": "instant"},
                *({"kind": "straight", "params": {"sound_speed_mps": c}} for c in (1500.0, 60.0)),
            ]
        ),
    }
)


@MODERATE
@given(NETWORKS, st.tuples(*[st.floats(-1.0, 1.0)] * 3))
def test_nothing_arrives_that_was_not_sent_nor_twice_nor_too_early(network, drift_mps):
    config = _config(**network)
    medium = AcousticMedium(config)
    starts = _line(config.fleet_size, 30.0)

    def positions_at(tick):
        return [
            tuple(x + tick * config.period_s * i * v for x, v in zip(start, drift_mps, strict=True))
            for i, start in enumerate(starts)
        ]

    packets, receptions = _chatter(medium, 50, positions_at)
    speed_mps = network["propagation"].get("params", {}).get("sound_speed_mps", math.inf)
    airtime_s = 8.0 * 40 / 5000.0
    sent = {(packet.source, packet.sequence): packet for packet in packets}
    seen = set()
    for tick, address, reception in receptions:
        packet = reception.packet
        assert sent[packet.source, packet.sequence] == packet
        assert address != packet.source
        assert _key(packet, address) not in seen
        seen.add(_key(packet, address))
        assert tick >= packet.tick + 1
        assert reception.sent_s >= packet.tick * config.period_s - 1e-8
        range_m = math.dist(positions_at(packet.tick)[packet.source - 1], positions_at(tick)[address - 1])
        assert reception.arrival_s == pytest.approx(reception.sent_s + airtime_s + range_m / speed_mps)
        assert reception.arrival_s <= tick * config.period_s + 2e-9
        assert math.isnan(reception.snr_db)


@MODERATE
@given(NETWORKS)
def test_counters_add_up(network):
    config = _config(**network, modem={"kind": "fixed_rate", "params": {"max_range_m": 95.0}})
    medium = AcousticMedium(config)
    packets, receptions = _chatter(medium, 40, lambda _tick: _line(config.fleet_size, 30.0))
    sent = Counter(packet.source for packet in packets)
    delivered = Counter((reception.packet.source, address) for _, address, reception in receptions)
    in_flight: Counter[Any] = Counter()
    for _, address, reception in _listen(medium, 40, 60, _line(config.fleet_size, 30.0)):
        in_flight[reception.packet.source, address] += 1
    for (source, address), link in medium.links.items():
        assert link.sent == sent[source]
        assert link.delivered == delivered[source, address] + in_flight[source, address]
        assert link.sent == link.delivered + link.lost


def _listen(medium, first, count, positions):
    """Return packets that arrive after all modems have stopped transmitting."""
    return [
        (tick, address, reception)
        for tick in range(first, first + count)
        for address, inbox in enumerate(medium.exchange(tick, _states(tick, positions)), start=1)
        for reception in inbox.receptions
    ]


@pytest.mark.parametrize("loss_prob", [0.05, 0.2, 0.6])
def test_losses_lie_in_their_binomial_band(loss_prob):
    medium = AcousticMedium(_config(outage={"kind": "bernoulli", "params": {"loss_prob": loss_prob}}))
    _chatter(medium, 3000, lambda _tick: _line(4))
    sent = sum(link.sent for link in medium.links.values())
    lost = sum(link.lost_outage for link in medium.links.values())
    assert sent > 3000
    low, high = stats.binom.interval(1.0 - 1e-6, sent, loss_prob)
    assert low <= lost <= high


@pytest.mark.parametrize("loss_prob", [0.0, 1.0])
def test_certain_luck_and_certain_loss_are_certain(loss_prob):
    medium = AcousticMedium(_config(outage={"kind": "bernoulli", "params": {"loss_prob": loss_prob}}))
    _chatter(medium, 200, lambda _tick: _line(4))
    _listen(medium, 200, 10, _line(4))
    for link in medium.links.values():
        assert link.lost_outage == loss_prob * link.sent
        assert link.delivered == (1.0 - loss_prob) * link.sent


def test_the_same_calls_give_the_same_deliveries():
    first, second = (
        _chatter(AcousticMedium(_config()), 400, lambda _tick: _line(4))[1] for _ in range(2)
    )  # fmt: skip
    assert repr(first) == repr(second)


def test_another_seed_loses_other_packets():
    def lost(seed):
        _, receptions = _chatter(AcousticMedium(_config(seed=seed)), 400, lambda _tick: _line(4))
        return {_key(reception.packet, address) for _, address, reception in receptions}

    assert lost(5) != lost(6)


def test_adding_a_vehicle_does_not_change_the_losses_of_the_others():
    def received(fleet_size):
        medium = AcousticMedium(_ideal(fleet_size=fleet_size, outage={"kind": "bernoulli"}))
        _, receptions = _chatter(medium, 200, lambda _tick: _line(fleet_size, 20.0), talkers={1, 2, 3})
        return {
            _key(r.packet, address)
            for _, address, r in receptions
            if address <= 3 and r.packet.sequence < 150
        }

    assert received(3) == received(4) == received(6)


def test_one_links_losses_do_not_depend_on_who_else_talks():
    def received(talkers):
        medium = AcousticMedium(_ideal(outage={"kind": "bernoulli"}))
        _, receptions = _chatter(medium, 200, lambda _tick: _line(4), talkers=talkers)
        return {_key(r.packet, address) for _, address, r in receptions if r.packet.source == 2}

    assert received({2}) == received({1, 2, 3, 4})


def test_beyond_the_range_nothing_is_heard_and_within_it_everything():
    mac = {"kind": "tdma", "params": {"slot_s": 0.5}}
    medium = AcousticMedium(_config(outage={"kind": "none"}, mac=mac))
    positions = [(0.0, 0.0, 5.0), (299.0, 0.0, 5.0), (-301.0, 0.0, 5.0), (0.0, 250.0, 5.0)]
    _, receptions = _chatter(medium, 100, lambda _tick: positions)
    pairs = {(reception.packet.source, address) for _, address, reception in receptions}
    assert (1, 2) in pairs
    assert not {(1, 3), (3, 1), (2, 3), (3, 2)} & pairs
    assert medium.links[1, 3].lost_range == medium.links[1, 3].sent > 0
    assert medium.links[1, 2].lost_range == 0


def test_the_ideal_medium_delivers_everything_in_the_next_tick():
    medium = AcousticMedium(_ideal())
    packets, receptions = _chatter(medium, 20, lambda _tick: _line(4, 1e5))
    assert len(packets) == 80
    assert {tick - reception.packet.tick for tick, _, reception in receptions} == {1}
    assert len(receptions) == 19 * 4 * 3


def test_receptions_of_an_inbox_are_in_the_order_of_arrival():
    config = _config(
        fleet_size=6, mac={"kind": "unlimited"}, outage={"kind": "none"},
        propagation={"kind": "straight", "params": {"sound_speed_mps": 300.0}},
    )  # fmt: skip
    medium = AcousticMedium(config)
    positions = _line(6, 40.0)
    _, receptions = _chatter(medium, 30, lambda _tick: positions)
    for address in range(1, 7):
        arrivals = [(tick, reception.arrival_s) for tick, who, reception in receptions if who == address]
        assert arrivals == sorted(arrivals)


def test_a_packet_to_one_modem_is_heard_by_that_one_only():
    medium = AcousticMedium(_ideal())
    medium.exchange(0, _states(0, _line(4)))
    medium.transmit({2: [Packet(0, 2, 3, 1, b"x")]}, _states(0, _line(4)))
    assert [len(inbox.receptions) for inbox in medium.exchange(1, _states(1, _line(4)))] == [0, 0, 1, 0]
    assert set(medium.links) == {(2, 3)}


def test_packets_out_of_turn_are_refused():
    medium = AcousticMedium(_config())
    with pytest.raises(
        ValueError, match="modem 2 was handed a packet in tick 0, in which it may not transmit"
    ):
        medium.transmit({2: [Packet(0, 2, 0, 1, b"x")]}, _states(0, _line(4)))


def test_a_second_packet_in_a_tick_is_refused():
    medium = AcousticMedium(_config())
    with pytest.raises(ValueError, match="modem 1 got 2 packets in one tick"):
        medium.transmit({1: [Packet(0, 1, 0, 1, b"x"), Packet(0, 1, 0, 2, b"x")]}, _states(0, _line(4)))


def test_a_payload_too_long_for_the_modem_is_refused():
    medium = AcousticMedium(_config(modem={"kind": "fixed_rate", "params": {"max_payload_bytes": 10}}))
    with pytest.raises(ValueError, match="modem 1 was handed 11 bytes; it takes 10"):
        medium.transmit({1: [Packet(0, 1, 0, 1, bytes(11))]}, _states(0, _line(4)))


def test_reports_that_do_not_fit_the_modem_or_the_slot_are_told_before_the_run():
    short = AcousticMedium(_config(modem={"kind": "fixed_rate", "params": {"max_payload_bytes": 64}}))
    with pytest.raises(ValueError, match=r"^modem\.params\.max_payload_bytes: 64 is not allowed"):
        short.check_payload(74)
    slow = AcousticMedium(_config(modem={"kind": "fixed_rate", "params": {"bit_rate_bps": 1000.0}}))
    with pytest.raises(ValueError, match=r"^mac\.params\.slot_s: 0\.25 is not allowed"):
        slow.check_payload(74)


@pytest.mark.parametrize("preamble_s", [0.0, 0.04])
def test_airtime_is_preamble_and_bits_over_the_rate(preamble_s):
    modem = {"kind": "fixed_rate", "params": {"preamble_s": preamble_s, "bit_rate_bps": 5000.0}}
    medium = AcousticMedium(_config(modem=modem, propagation={"kind": "instant"}, outage={"kind": "none"}))
    _, receptions = _chatter(medium, 20, lambda _tick: _line(4), size=74)
    for _, _, reception in receptions:
        assert reception.arrival_s - reception.sent_s == pytest.approx(preamble_s + 0.1184)


@pytest.mark.parametrize(
    ("key", "source", "destination"), [(1, 2, 0), (1, 200, 0), (9, 9, 0), (1, 0, 0), (1, 1, 77)]
)
def test_a_packet_with_a_false_address_is_refused_and_nothing_is_sent(key, source, destination):
    medium, states = AcousticMedium(_ideal()), _states(0, _line(4))
    medium.exchange(0, states)
    with pytest.raises(ValueError, match=r"modem \d+ was handed a packet"):
        medium.transmit({key: [Packet(0, source, destination, 1, b"x")]}, states)
    assert medium.take_events() == []
