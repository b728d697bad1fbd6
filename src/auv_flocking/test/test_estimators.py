"""Claims about the estimators: ours and filterpy's give the same numbers, the unscented one similar ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.params import load
from auv_core.plugins import list_plugins
from auv_flocking.neighbours.filter import ESTIMATORS, NeighbourConfig
from auv_flocking.neighbours.synthetic_neighbour import Setting, fly
from auv_flocking.neighbours.table import NeighbourTable

AS_FLOWN = {"acceleration_memory_s": 60.0, "velocity_memory_s": 15.0}
SETTINGS = st.builds(
    Setting,
    loss_prob=st.sampled_from([0.0, 0.5]),
    lateness_s=st.tuples(st.just(0.1), st.floats(0.2, 6.0)),
    sonar_every_s=st.sampled_from([0.0, 0.5]),
    own_rate_mps=st.sampled_from([0.0, 0.0075]),
    sender_rate_mps=st.sampled_from([0.0, 0.0075]),
    own_fixes_s=st.sampled_from([(), (13.0,)]),
    sender_fixes_s=st.sampled_from([(), (9.0, 21.0)]),
)


def _fly_with(kinds, setting, seed, duration_s, **changes):
    """Yield the truth and the rows of estimates by each of the estimators, on the same measurements."""
    configs = [
        load(NeighbourConfig, {"estimator": {"kind": kind}, **changes}, "neighbours") for kind in kinds
    ]
    tables = [NeighbourTable(config) for config in configs]
    for now in fly(setting, configs[0], np.random.default_rng(seed), duration_s):
        for table in tables:
            for report in now.reports:
                table.receive(report)
            table.observe(now.t_s, now.nav, now.contacts)
        found = [table.estimates(now.t_s, now.nav) for table in tables]
        if found[0]:
            yield now.truth, [estimates.rows[0, :42] for estimates in found]


def test_there_are_three():
    assert {"ekf", "filterpy_ekf", "filterpy_ukf"} <= set(list_plugins(ESTIMATORS))


@settings(max_examples=12, deadline=None)
@given(SETTINGS, st.integers(0, 10**6), st.sampled_from([{}, AS_FLOWN]))
def test_our_filter_and_filterpys_agree(setting, seed, changes):
    """With late packets, sonar, drift and fixes."""
    for _, (ours, theirs) in _fly_with(("ekf", "filterpy_ekf"), setting, seed, 30.0, **changes):
        np.testing.assert_allclose(theirs, ours, rtol=1e-9, atol=1e-9)


@pytest.mark.slow
def test_they_agree_over_a_whole_flight():
    setting = Setting(loss_prob=0.3, sonar_every_s=0.5, own_rate_mps=0.0075, own_fixes_s=(60.0, 300.0))
    for _, (ours, theirs) in _fly_with(("ekf", "filterpy_ekf"), setting, 7, 650.0, **AS_FLOWN):
        np.testing.assert_allclose(theirs, ours, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_without_sonar_the_models_are_linear_and_the_unscented_filter_agrees_too(seed):
    setting = Setting(loss_prob=0.3, own_rate_mps=0.0075)
    for _, (ours, theirs) in _fly_with(("ekf", "filterpy_ukf"), setting, seed, 30.0):
        np.testing.assert_allclose(theirs, ours, rtol=1e-6, atol=1e-7)


def test_with_sonar_the_unscented_filter_is_as_good():
    setting, squares = Setting(packets_every_s=8.0, sonar_every_s=0.5), []
    for seed in range(4):
        for truth, rows in _fly_with(("ekf", "filterpy_ukf"), setting, seed, 40.0):
            squares.append([np.square(row[:3] - truth[:3]).sum() for row in rows])
    ours_m, theirs_m = np.sqrt(np.mean(squares, axis=0))
    assert theirs_m == pytest.approx(ours_m, rel=0.1)
