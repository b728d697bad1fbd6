"""Claims about the laws of coordination along a path, with packets that are late, lost and few."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_flocking.coordination import LanePlace, Pace, age_matched, reference_consensus, tanh
from auv_flocking.lanes.status import LaneNeighbour, LaneStatus, Mode

PACE = Pace(1.5, 1742.5, 0.2)
OPEN = Pace(1.5, 0.0, 0.2)
LAWS = {
    "reference_consensus": reference_consensus.Coordination(reference_consensus.Params(), PACE),
    "tanh": tanh.Coordination(tanh.Params(), PACE),
    "age_matched": age_matched.Coordination(age_matched.Params(), PACE),
}
EVERY = pytest.mark.parametrize("kind", LAWS)
AT_REST = (0.0, 0.0, 0.0)


def told(address, t_s, gamma_m, r_m=0.0, *, rate_mps=0.0, is_limited=False):
    """Return a neighbour whose packet was sent at `t_s` with these numbers."""
    status = LaneStatus(gamma_m, r_m, rate_mps, Mode.INLANE, is_limited, 6, 30.0)
    return LaneNeighbour(address, t_s, status, t_s, AT_REST, AT_REST)


def spread_m(kind, starts_m, *, every_s=4.0, loss_prob=0.3, delay_s=2.0, duration_s=600.0, seed=1):
    """Return the spread of the path parameters (m) of points that follow the law's speed at once."""
    law, count, rng = LAWS[kind], len(starts_m), np.random.default_rng(seed)
    gammas = list(starts_m)
    states = [law.begin(LanePlace(0.0, gamma)) for gamma in gammas]
    heard: list[dict[int, LaneNeighbour]] = [{} for _ in gammas]
    on_air: list[tuple[float, int, LaneNeighbour]] = []
    spreads = []
    for tick in range(round(duration_s / PACE.period_s)):
        t_s = tick * PACE.period_s
        if tick % round(every_s / PACE.period_s) == 0:
            sender = (tick // round(every_s / PACE.period_s)) % count
            own = LanePlace(t_s, gammas[sender])
            packet = told(sender, t_s, gammas[sender], law.reference_m(states[sender], own))
            on_air += [
                (t_s + delay_s, k, packet) for k in range(count) if k != sender and rng.random() >= loss_prob
            ]
        for _, receiver, packet in [each for each in on_air if each[0] <= t_s]:
            heard[receiver][packet.address] = packet
            states[receiver] = law.hear(states[receiver], LanePlace(t_s, gammas[receiver]), packet)
        on_air = [each for each in on_air if each[0] > t_s]
        for k in range(count):
            own = LanePlace(t_s, gammas[k])
            correction, states[k] = law.step(states[k], own, list(heard[k].values()))
            assert abs(correction) <= 0.4
            gammas[k] += PACE.period_s * (PACE.speed_mps + correction)
        spreads.append(max(gammas) - min(gammas))
    return spreads


@EVERY
def test_path_parameters_come_together(kind):
    assert spread_m(kind, (0.0, 30.0, -20.0))[-1] < 0.3


def test_only_the_reference_does_not_mind_few_and_old_packets():
    apart = {
        kind: max(
            spread_m(kind, (0.0, 30.0, -20.0, 8.0, 2.0), every_s=10.0, loss_prob=0.6, duration_s=1500.0)[
                -2000:
            ]
        )
        for kind in LAWS
    }
    assert apart["reference_consensus"] < 0.1
    assert apart["reference_consensus"] < apart["tanh"] < apart["age_matched"]


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-50.0, 50.0), min_size=2, max_size=5), st.floats(0.0, 0.9), st.integers(0, 1000))
def test_references_stay_between_the_extremes_of_the_start(starts_m, loss_prob, seed):
    law, rng = LAWS["reference_consensus"], np.random.default_rng(seed)
    references = [law.begin(LanePlace(0.0, start)) for start in starts_m]
    packets = [list(references)]
    for _ in range(40):
        for i in range(len(starts_m)):
            j = int(rng.integers(len(starts_m)))
            if i != j and rng.random() >= loss_prob:
                (old,) = packets[int(rng.integers(len(packets)))][j]
                references[i] = law.hear(references[i], LanePlace(0.0, 0.0), told(j, 0.0, 0.0, old))
        packets.append(list(references))
    assert all(min(starts_m) - 1e-9 <= r <= max(starts_m) + 1e-9 for (r,) in references)


@EVERY
def test_alone_a_vehicle_keeps_the_common_speed(kind):
    law, own = LAWS[kind], LanePlace(100.0, 340.0)
    correction, _ = law.step(law.begin(own), own, ())
    assert correction == pytest.approx(0.0)


@EVERY
def test_whole_rounds_do_not_count(kind):
    law, own = LAWS[kind], LanePlace(10.0, 15.0)
    results = []
    for rounds in (0, 3):
        other = told(2, 10.0, 20.0 + rounds * PACE.round_m, 5.0 + rounds * PACE.round_m)
        state = law.hear(law.begin(own), own, other)
        results.append(law.step(state, own, (other,))[0])
    assert results[0] == pytest.approx(results[1])
    assert results[0] > 0.0


def test_the_gain_of_the_age_matched_law_falls_with_age():
    law = LAWS["age_matched"]
    fresh, _ = law.step((0.0,), LanePlace(100.0, 0.0), (told(2, 100.0, 1.0),))
    old, _ = law.step((0.0,), LanePlace(100.0, 0.0), (told(2, 70.0, 1.0 - 45.0),))
    assert fresh == pytest.approx(0.1)
    assert old == pytest.approx(0.3 / 30.0)


def test_receivers_predict_the_reference_and_not_the_way_to_it():
    sent = told(1, 50.0, 80.0, 2.0).status
    assert LAWS["reference_consensus"].predicted_m(sent, 50.0, 60.0) == 92.0
    assert LAWS["tanh"].predicted_m(sent, 50.0, 60.0) == 95.0


def test_a_vehicle_that_cannot_keep_up_lets_its_reference_fall_and_others_wait():
    law = LAWS["reference_consensus"]
    correction, (r_m,) = law.step((10.0,), LanePlace(100.0, 150.0, True), ())
    assert r_m == 2.0
    assert correction == pytest.approx(0.2)
    slow = told(2, 80.0, 100.0, -20.0, rate_mps=-0.1, is_limited=True)
    _, (waiting_m,) = law.step((10.0,), LanePlace(100.0, 160.0), (slow,))
    assert waiting_m == pytest.approx(-22.0)
    _, (passed_m,) = law.step((10.0,), LanePlace(300.0, 460.0), (slow,))
    assert passed_m == 10.0, "a packet older than 200 s is no cap"


def test_on_an_open_path_there_are_no_rounds():
    law = reference_consensus.Coordination(reference_consensus.Params(), OPEN)
    (r_m,) = law.hear((0.0,), LanePlace(0.0, 0.0), told(2, 0.0, 0.0, 2000.0))
    assert r_m == 1000.0
    assert math.isfinite(law.step((r_m,), LanePlace(0.0, 0.0), ())[0])
