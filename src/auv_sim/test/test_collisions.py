"""Claims about the reception of overlapping signals."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from auv_core.messages import Outcome, Packet
from auv_core.params import load, load_section
from auv_sim.acoustics.medium import MODEM, OUTAGE, PROPAGATION
from auv_sim.acoustics.modem import fixed_rate, noise_limited
from auv_sim.acoustics.outage import none
from auv_sim.acoustics.propagation import straight
from auv_sim.acoustics.receiver import Receiver, Transmission

MODERATE = settings(max_examples=60, deadline=None)
ME, HERE = 9, (0.0, 0.0, 10.0)
PLAIN = fixed_rate.Modem(fixed_rate.Params(bit_rate_bps=1000.0))
CAPTURING = fixed_rate.Modem(fixed_rate.Params(bit_rate_bps=1000.0, capture=True))


def _noisy(**params):
    return noise_limited.Modem(noise_limited.Params(source_level_db=150.0, bit_rate_bps=1000.0, **params))


def _receiver(modem, *, spreading_exponent=1.5, seed=1):
    propagation = straight.Propagation(straight.Params(spreading_exponent=spreading_exponent))
    return Receiver(ME, modem, propagation, none.Outage(none.Params(), seed), seed)


def _at(range_m):
    return (range_m, 0.0, 10.0)


def _send(receiver, modem, source, start_s, range_m=15.0, *, size=32, sequence=1):
    packet = Packet(0, source, 0, sequence, bytes(size))
    receiver.expect(Transmission(packet, start_s, start_s + modem.airtime_s(size), _at(range_m)))


def _outcomes(receiver, until_s=20.0, period_s=0.1):
    """Listen tick by tick; return {source: outcome}."""
    found = {}
    for tick in range(round(until_s / period_s) + 1):
        for signal in receiver.listen(tick * period_s, HERE):
            found[signal.transmission.packet.source] = signal.outcome
    return found


def test_one_signal_is_heard():
    receiver = _receiver(PLAIN)
    _send(receiver, PLAIN, 1, 0.03)
    assert _outcomes(receiver) == {1: Outcome.DELIVERED}


@pytest.mark.parametrize(("modem", "first"), [(PLAIN, Outcome.COLLISION), (CAPTURING, Outcome.DELIVERED)])
@pytest.mark.parametrize("later_s", [0.001, 0.05, 0.1, 0.2, 0.25])
def test_any_overlap_loses_both_or_with_capture_the_second(modem, first, later_s):
    receiver = _receiver(modem)
    _send(receiver, modem, 1, 0.03)
    _send(receiver, modem, 2, 0.03 + later_s)
    assert _outcomes(receiver) == {1: first, 2: Outcome.COLLISION}


@pytest.mark.parametrize("modem", [PLAIN, CAPTURING])
def test_signals_that_follow_each_other_are_both_heard(modem):
    receiver = _receiver(modem)
    for source in range(1, 8):
        _send(receiver, modem, source, 0.03 + (source - 1) * modem.airtime_s(32))
    assert set(_outcomes(receiver).values()) == {Outcome.DELIVERED}


def test_what_counts_is_when_signals_meet_at_the_receiver_not_when_they_are_sent():
    receiver = _receiver(PLAIN)
    _send(receiver, PLAIN, 1, 0.0, 15.0)
    _send(receiver, PLAIN, 2, 0.0, 900.0)
    assert set(_outcomes(receiver).values()) == {Outcome.DELIVERED}
    receiver = _receiver(PLAIN)
    _send(receiver, PLAIN, 1, 0.5, 15.0)
    _send(receiver, PLAIN, 2, 0.0, 765.0)
    assert set(_outcomes(receiver).values()) == {Outcome.COLLISION}


def test_what_is_out_of_range_disturbs_nobody():
    receiver = _receiver(PLAIN)
    _send(receiver, PLAIN, 1, 1.0, 15.0)
    _send(receiver, PLAIN, 2, 0.3, 1065.0)
    assert _outcomes(receiver) == {1: Outcome.DELIVERED, 2: Outcome.RANGE}


@pytest.mark.parametrize("modem", [PLAIN, CAPTURING, _noisy(), _noisy(capture=False)])
@MODERATE
@given(own_s=st.floats(0.0, 2.0), sent_s=st.floats(0.0, 2.0))
def test_a_modem_hears_nothing_that_overlaps_with_its_own_transmission(modem, own_s, sent_s):
    receiver = _receiver(modem)
    airtime_s = modem.airtime_s(32)
    receiver.go_deaf(own_s, own_s + airtime_s)
    _send(receiver, modem, 1, sent_s)
    overlap_s = airtime_s - abs(sent_s + 0.01 - own_s)
    if abs(overlap_s) > 1e-6:
        expected = Outcome.HALF_DUPLEX if overlap_s > 0.0 else Outcome.DELIVERED
        assert _outcomes(receiver) == {1: expected}


def test_an_own_transmission_ends_a_reception_and_the_next_signal_can_be_received():
    receiver = _receiver(CAPTURING)
    _send(receiver, CAPTURING, 1, 0.0, size=256)
    receiver.go_deaf(0.5, 0.6)
    _send(receiver, CAPTURING, 2, 0.7)
    assert _outcomes(receiver) == {1: Outcome.HALF_DUPLEX, 2: Outcome.DELIVERED}


def test_the_first_signal_is_kept_however_strong_the_second_is():
    modem = _noisy()
    receiver = _receiver(modem)
    _send(receiver, modem, 1, 0.00, 100.0)
    _send(receiver, modem, 2, 0.15, 1.0)
    assert _outcomes(receiver) == {1: Outcome.COLLISION, 2: Outcome.COLLISION}


@pytest.mark.parametrize(("sent_s", "outcome"), [(0.0, Outcome.COLLISION), (0.2, Outcome.DELIVERED)])
def test_a_distant_signal_harms_a_near_one_only_by_being_first(sent_s, outcome):
    modem = _noisy()
    receiver = _receiver(modem)
    _send(receiver, modem, 1, 0.5, 1.0)
    _send(receiver, modem, 2, sent_s, 600.0)
    assert _outcomes(receiver)[1] is outcome


def test_without_capture_a_distant_signal_harms_a_near_one_if_it_can_be_recognised():
    modem = _noisy(capture=False)
    for range_m, outcome in ((600.0, Outcome.COLLISION), (6000.0, Outcome.DELIVERED)):
        receiver = _receiver(modem)
        _send(receiver, modem, 1, 5.0, 1.0)
        _send(receiver, modem, 2, 5.1 - range_m / 1500.0, range_m)
        assert _outcomes(receiver)[1] is outcome


def test_too_weak_to_be_recognised_is_lost_to_noise():
    modem = _noisy()
    receiver = _receiver(modem)
    _send(receiver, modem, 1, 0.0, 6000.0)
    assert _outcomes(receiver) == {1: Outcome.NOISE}


def _share_of(outcome, modem, packets, *, range_m, rival_range_m=None, overlap_s=None):
    """Return how many of many packets have an outcome, each at a receiver with its own random numbers."""
    count = 0
    for sequence in range(packets):
        receiver = _receiver(modem)
        _send(receiver, modem, 1, 1.0 - range_m / 1500.0, range_m, sequence=sequence)
        if rival_range_m is not None:
            start_s = 1.0 + modem.airtime_s(32) - overlap_s - rival_range_m / 1500.0
            _send(receiver, modem, 2, start_s, rival_range_m, sequence=sequence)
        signals = [*receiver.listen(1.0, HERE), *receiver.listen(5.0, HERE)]
        count += sum(s.outcome is outcome for s in signals if s.transmission.packet.source == 1)
    return count


def _range_with(modem, snr_db):
    """Return the range (m) at which a modem's signal is so strong, by bisection."""
    low_m, high_m = 1.0, 1e5
    propagation = straight.Propagation(straight.Params())
    for _ in range(100):
        middle_m = 0.5 * (low_m + high_m)
        loss_db = propagation.loss_db(HERE, _at(middle_m), modem.frequency_khz)
        louder = 10.0 * math.log10(modem.snr_ratio(loss_db)) > snr_db
        low_m, high_m = (middle_m, high_m) if louder else (low_m, middle_m)
    return low_m


@pytest.mark.parametrize("modulation", ["bpsk", "fsk"])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_losses_to_noise_lie_in_the_band_of_the_packet_error_probability(modulation, share):
    modem = _noisy(modulation=modulation, acquisition_db=-10.0)
    snr_db = _snr_db_of(modem, share)
    lost = _share_of(Outcome.NOISE, modem, 400, range_m=_range_with(modem, snr_db))
    low, high = stats.binom.interval(1.0 - 1e-6, 400, share)
    assert low <= lost <= high


def _snr_db_of(modem, share):
    low_db, high_db = -20.0, 30.0
    for _ in range(60):
        middle_db = 0.5 * (low_db + high_db)
        value = -math.expm1(modem.log_success(10.0 ** (0.1 * middle_db), 32))
        low_db, high_db = (middle_db, high_db) if value > share else (low_db, middle_db)
    return low_db


@pytest.mark.parametrize("part", [0.1, 0.5, 1.0])
def test_only_the_bits_that_overlap_suffer(part):
    modem = _noisy(acquisition_db=-10.0)
    near_m, rival_m = _range_with(modem, 25.0), _range_with(modem, 27.0)
    overlap_s = part * modem.airtime_s(32) - 1e-6
    sinr = 10.0**2.5 / (1.0 + 10.0**2.7)
    share = -math.expm1(part * modem.log_success(sinr, 32))
    lost = _share_of(
        Outcome.COLLISION, modem, 400, range_m=near_m, rival_range_m=rival_m, overlap_s=overlap_s
    )
    low, high = stats.binom.interval(1.0 - 1e-6, 400, share)
    assert low <= lost <= high


@MODERATE
@given(st.floats(0.0, 1.0), st.floats(0.0, 400.0), st.floats(0.0, 400.0))
def test_more_interference_never_helps(start_s, range_m, farther_m):
    """The rival is drawn ever nearer; a packet that was lost stays lost."""
    modem = _noisy()
    delivered = []
    for rival_m in sorted((500.0 + range_m, 500.0 + range_m + farther_m), reverse=True):
        receiver = _receiver(modem)
        _send(receiver, modem, 1, 1.0, 500.0)
        _send(receiver, modem, 2, 1.0 + start_s + (500.0 - rival_m) / 1500.0, rival_m)
        delivered.append(_outcomes(receiver, 4.0)[1] is Outcome.DELIVERED)
    assert delivered == sorted(delivered, reverse=True)


def test_luck_belongs_to_the_packet_and_not_to_what_was_asked_before():
    modem = _noisy(acquisition_db=-10.0)
    range_m = _range_with(modem, _snr_db_of(modem, 0.5))

    def lost(sequences):
        found = set()
        for sequence in sequences:
            receiver = _receiver(modem)
            _send(receiver, modem, 1, 0.0, range_m, sequence=sequence)
            if receiver.listen(9.0, HERE)[0].outcome is Outcome.NOISE:
                found.add(sequence)
        return found

    forward = lost(range(60))
    assert 10 < len(forward) < 50
    assert lost(reversed(range(60))) == forward


def test_nothing_is_remembered_longer_than_needed():
    modem = _noisy()
    receiver = _receiver(modem)
    for tick in range(2000):
        receiver.go_deaf(0.1 * tick, 0.1 * tick + 0.01)
        _send(receiver, modem, 1 + tick % 3, 0.1 * tick + 0.02, sequence=tick)
        receiver.listen(0.1 * tick, HERE)
    assert len(receiver._signals) < 20
    assert len(receiver._own) < 20


@MODERATE
@given(
    st.fixed_dictionaries(
        {
            "source_level_db": st.none() | st.floats(0.0, 250.0),
            "power_w": st.floats(1e-300, 1e6),
            "directivity_db": st.floats(-60.0, 60.0),
            "carrier_hz": st.floats(10.0, 1e6),
            "bandwidth_hz": st.floats(1.0, 1e6),
            "modulation": st.sampled_from(["bpsk", "fsk"]),
            "code": st.sampled_from(["none", "convolutional_1_2_k9"]),
            "frame_bytes": st.sampled_from([1, 32]),
            "bit_rate_bps": st.floats(1e-3, 1e9),
            "preamble_s": st.floats(0.0, 10.0),
            "wind_mps": st.floats(0.0, 100.0),
            "capture": st.booleans(),
        }
    ),
    st.lists(st.tuples(st.floats(0.0, 3.0), st.floats(0.0, 1e6), st.integers(0, 300)), max_size=5),
    st.floats(0.0, 4.0),
)
def test_no_number_is_too_large_or_too_small(params, sendings, exponent):
    modem = noise_limited.Modem(load(noise_limited.Params, params, "params"))
    receiver = _receiver(modem, spreading_exponent=exponent)
    for source, (start_s, range_m, size) in enumerate(sendings, start=1):
        _send(receiver, modem, source, start_s, range_m, size=size)
    for now_s in (0.0, 1.0, 2.0, 10.0, 1e9):
        for signal in receiver.listen(now_s, HERE):
            assert signal.outcome in set(Outcome) - {Outcome.SENT, Outcome.RANGE, Outcome.OUTAGE}
            assert math.isfinite(signal.snr_db)


@pytest.mark.parametrize("folder", [PROPAGATION, MODEM, OUTAGE])
def test_every_part_can_be_chosen_by_name(folder):
    kind = {PROPAGATION: "mackenzie", MODEM: "noise_limited", OUTAGE: "gilbert_elliott"}[folder]
    assert load_section({"kind": kind}, "x", folder).kind == kind
