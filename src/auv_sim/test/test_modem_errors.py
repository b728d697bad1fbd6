"""Claims about Eb/N0, codes, published frame errors and durations of modems with sound levels."""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import auv_sim.acoustics
from auv_core.params import ConfigError, load
from auv_sim.acoustics import codes, water
from auv_sim.acoustics.modem.noise_limited import Modem, Params

MODERATE = settings(max_examples=60, deadline=None)
PRESETS = ("micromodem_fsk", "micromodem_psk", "micromodem_fdp", "evologics_s2c")
# Frame errors of WHOI's packet performance simulation at rate 5, in its own numbers: signal to noise in dB.
WHOI_RATE_5 = {3.09699410930214: 1.0, 4.44256115246717: 0.135, 6.01504558096942: 0.0}


def _preset(name):
    path = Path(auv_sim.acoustics.__file__).parent / "presets" / f"{name}.yaml"
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def _modem(name, **changes):
    return Modem(load(Params, {**_preset(name)["modem"]["params"], **changes}, "modem"))


def _error_prob(modem, snr_db, payload_bytes=32):
    return -math.expm1(modem.log_success(10.0 ** (0.1 * snr_db), payload_bytes))


def _snr_db_of(modem, share):
    """Return the ratio within the band (dB) at which a share of the packets of 32 bytes is lost."""
    low_db, high_db = -40.0, 40.0
    for _ in range(60):
        middle_db = 0.5 * (low_db + high_db)
        if _error_prob(modem, middle_db) > share:
            low_db = middle_db
        else:
            high_db = middle_db
    return low_db


def _reach_m(name):
    """Return where half of the packets of 32 bytes are lost (m)."""
    modem, params = _modem(name), _preset(name)["modem"]["params"]
    exponent = _preset(name)["propagation"]["params"]["spreading_exponent"]
    ranges_m = np.arange(1000.0, 9000.0, 5.0)
    for range_m in ranges_m:
        snr = modem.snr_ratio(water.transmission_loss_db(range_m, params["carrier_hz"] / 1e3, exponent))
        if not modem.acquires(snr) or modem.log_success(snr, 32) < math.log(0.5):
            return range_m
    raise AssertionError(f"{name} is heard everywhere")


@pytest.mark.parametrize(("modulation", "ebn0_db"), [("bpsk", 9.59), ("fsk", 13.35)])
@pytest.mark.parametrize(("bandwidth_hz", "bit_rate_bps"), [(4000.0, 80.0), (5000.0, 5000.0), (1e3, 4e3)])
def test_the_ratio_in_the_band_lies_below_ebn0_by_band_over_bit_rate(
    modulation, ebn0_db, bandwidth_hz, bit_rate_bps
):
    modem = Modem(Params(modulation=modulation, bandwidth_hz=bandwidth_hz, bit_rate_bps=bit_rate_bps))
    snr_db = ebn0_db - 10.0 * math.log10(bandwidth_hz / bit_rate_bps)
    assert _error_prob(modem, snr_db, 1) == pytest.approx(8e-5, rel=0.02)


@MODERATE
@given(st.floats(-20.0, 20.0), st.floats(100.0, 1e4), st.floats(10.0, 1e4), st.sampled_from(["bpsk", "fsk"]))
def test_a_wider_band_of_the_same_noise_changes_nothing(snr_db, bandwidth_hz, bit_rate_bps, modulation):
    """Twice the band has twice the noise: the level needed for a bit rate stays the same."""
    common = {"modulation": modulation, "bit_rate_bps": bit_rate_bps, "source_level_db": 180.0}
    narrow = Modem(Params(bandwidth_hz=bandwidth_hz, **common))
    wide = Modem(Params(bandwidth_hz=2.0 * bandwidth_hz, **common))
    loss_db = 10.0 * math.log10(narrow.snr_ratio(0.0)) - snr_db
    logs = [modem.log_success(modem.snr_ratio(loss_db), 32) for modem in (narrow, wide)]
    assert logs[0] == pytest.approx(logs[1], rel=1e-6, abs=1e-12)


def test_hopped_fsk_reaches_farther_than_psk():
    assert _reach_m("micromodem_fsk") > 1.2 * _reach_m("micromodem_psk")


@pytest.mark.parametrize(
    ("name", "reach_m"),
    [
        ("micromodem_fsk", 6785.0), ("micromodem_psk", 5140.0), ("micromodem_fdp", 5140.0),
        ("evologics_s2c", 3510.0),
    ],
)  # fmt: skip
def test_presets_reach_as_far_as_the_docs_say(name, reach_m):
    assert _reach_m(name) == pytest.approx(reach_m, abs=15.0)


@pytest.mark.parametrize(
    ("name", "payload_bytes", "airtime_s"),
    [
        ("micromodem_fsk", 32, 3.2 + 0.3), ("micromodem_fsk", 1, 3.5),
        ("micromodem_psk", 32, 3.0 + 0.3), ("micromodem_psk", 2048, 3.3),
        ("micromodem_fdp", 32, 0.286 + 0.3), ("micromodem_fdp", 96, 0.586),
        ("evologics_s2c", 32, 0.1 + 256 / 976), ("evologics_s2c", 64, 0.1 + 512 / 976),
    ],
)  # fmt: skip
def test_packets_last_as_long_as_those_of_the_real_modems(name, payload_bytes, airtime_s):
    assert _modem(name).airtime_s(payload_bytes) == pytest.approx(airtime_s)


@pytest.mark.parametrize("name", ["micromodem_psk", "micromodem_fdp"])
@pytest.mark.parametrize(("snr_db", "error_prob"), list(WHOI_RATE_5.items()))
def test_frame_errors_of_rate_5_are_those_of_whoi(name, snr_db, error_prob):
    assert _error_prob(_modem(name), snr_db) == pytest.approx(error_prob, abs=1e-3)


@MODERATE
@given(st.floats(-60.0, 60.0))
def test_frame_errors_are_linear_between_the_published_points(snr_db):
    expected = np.interp(snr_db, list(WHOI_RATE_5), list(WHOI_RATE_5.values()))
    assert _error_prob(_modem("micromodem_psk"), snr_db) == pytest.approx(expected, abs=1e-3)


def test_frames_of_a_packet_fail_each_for_itself():
    modem = _modem("micromodem_psk")
    one = _error_prob(modem, 4.8, 256)
    assert 0.05 < one < 0.135
    assert _error_prob(modem, 4.8, 1) == one
    assert _error_prob(modem, 4.8, 257) == pytest.approx(1.0 - (1.0 - one) ** 2)
    assert _error_prob(modem, 4.8, 2048) == pytest.approx(1.0 - (1.0 - one) ** 8)


def _parity(value):
    return bin(value).count("1") % 2


def _outputs(state, bit):
    """Return the two bits on the air and the next state of the code with generators 561 and 753."""
    register = (bit << 8) | state
    return (_parity(register & 0o561), _parity(register & 0o753)), register >> 1


def _counted_paths(farthest):
    """Count paths that leave state 0 and come back to it, by the weight of what they put on the air."""
    (first, state) = _outputs(0, 1)
    alive = {(state, sum(first)): 1}
    found: dict[int, int] = {}
    while alive:
        following: dict[tuple[int, int], int] = {}
        for (state, weight), count in alive.items():
            for bit in (0, 1):
                pair, after = _outputs(state, bit)
                total = weight + sum(pair)
                if total > farthest:
                    continue
                if after == 0:
                    found[total] = found.get(total, 0) + count
                else:
                    following[after, total] = following.get((after, total), 0) + count
        alive = following
    return found


def test_the_codes_paths_are_counted_right():
    farthest = max(codes.PATHS_K9)
    assert _counted_paths(farthest) == codes.PATHS_K9


def _decoded_wrong(error_prob, bits, packets, seed):
    """Return which packets of zeros Viterbi's algorithm gets wrong, from hard decisions, with 8 tail bits."""
    states = np.arange(256)
    rng = np.random.default_rng(seed)
    metric = np.full((packets, 256), 1e6)
    metric[:, 0] = 0.0
    choices = []
    sources = [np.array([((s << 1) | low) & 0xFF for s in range(256)]) for low in (0, 1)]
    pairs = [
        np.array([_outputs(source, s >> 7)[0] for s, source in zip(states, own, strict=True)])
        for own in sources
    ]
    for _ in range(bits + 8):
        heard = rng.random((packets, 2)) < error_prob
        costs = [
            metric[:, own] + (heard[:, :1] != pair[:, 0]) + (heard[:, 1:] != pair[:, 1])
            for own, pair in zip(sources, pairs, strict=True)
        ]
        choices.append(costs[1] < costs[0])
        metric = np.minimum(*costs)
    state = np.zeros(packets, dtype=int)
    is_wrong = np.zeros(packets, dtype=bool)
    for choice in reversed(choices):
        is_wrong |= state >> 7 == 1
        state = np.where(choice[np.arange(packets), state], sources[1][state], sources[0][state])
    return is_wrong


@pytest.mark.parametrize("error_prob", [0.05, 0.06, 0.065])
def test_viterbis_algorithm_loses_at_most_what_the_bound_says(error_prob):
    packets = 300
    bound = -math.expm1(256.0 * math.log1p(-codes.convolutional_k9_event_prob(error_prob)))
    lost = int(_decoded_wrong(error_prob, 256, packets, 11).sum())
    assert lost < packets * bound + 4.0 * math.sqrt(packets * bound * (1.0 - bound))


def test_the_bound_costs_less_than_1_5_db_at_the_edge_of_the_reach():
    """Where the bound loses half of the packets of FSK, Viterbi's algorithm does so at a lower level."""
    edge_ebn0_db = _snr_db_of(_modem("micromodem_fsk"), 0.5) + 10.0 * math.log10(4000.0 / 80.0)
    weaker = 0.5 * 10.0 ** (0.1 * (edge_ebn0_db - 1.5))
    assert _decoded_wrong(water.fsk_bit_error_prob(weaker), 256, 300, 12).mean() > 0.5


def test_the_code_gains_in_ebn0_but_not_more_than_its_free_distance_allows():
    """At 1e-5 hard decisions gain 3 to 4 dB for BPSK; 10 log10(rate x 12 / 2) = 4.8 dB is the most."""
    gains_db = {}
    for modulation in ("bpsk", "fsk"):
        plain, coded = (Modem(Params(code=code, modulation=modulation)) for code in codes.CODES)
        gains_db[modulation] = _snr_db_of(plain, 256e-5) - _snr_db_of(coded, 256e-5)
    assert 3.0 < gains_db["bpsk"] < 4.8
    assert 1.5 < gains_db["fsk"] < gains_db["bpsk"]


@MODERATE
@given(st.floats(0.0, 0.5), st.floats(0.0, 0.5))
def test_more_errors_on_the_air_are_never_fewer_after_decoding(one, other):
    low, high = sorted((one, other))
    values = [codes.convolutional_k9_event_prob(p) for p in (low, high)]
    assert 0.0 <= values[0] <= values[1] + 1e-15
    assert values[1] <= 0.5


@pytest.mark.parametrize("name", PRESETS)
def test_a_louder_packet_is_never_lost_more_often(name):
    modem = _modem(name)
    logs = [modem.log_success(10.0 ** (0.1 * snr_db), 32) for snr_db in np.linspace(-60.0, 60.0, 481)]
    assert all(a <= b for a, b in pairwise(logs))
    assert math.exp(logs[0]) < 1e-70
    assert logs[-1] == 0.0


@pytest.mark.parametrize(
    ("params", "words"),
    [
        ({"packet_s": 0.2, "preamble_s": 0.3}, r"packet_s: 0\.2 is not allowed; allowed: more than"),
        ({"frame_error_snr_db": [1.0]}, "frame_error_probs: 0 values are not allowed; allowed: one for each"),
        (
            {"frame_error_snr_db": [1.0, 1.0], "frame_error_probs": [1.0, 0.0]},
            r"frame_error_snr_db: \[1\.0, 1\.0\] is not allowed; allowed: increasing",
        ),
        (
            {"frame_error_snr_db": [1.0, 2.0], "frame_error_probs": [0.0, 1.0]},
            r"frame_error_probs: \[0\.0, 1\.0\] is not allowed; allowed: falling",
        ),
    ],
)  # fmt: skip
def test_what_is_no_modem_is_refused(params, words):
    with pytest.raises(ConfigError, match=rf"^modem\.{words}"):
        load(Params, params, "modem")
