"""Claims about the filter's arithmetic: it is filterpy's, and keeps what a covariance must keep."""

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_flocking.neighbours.kalman import predicted, updated

MODERATE = settings(max_examples=50, deadline=None)


def _covariance(rng, n):
    root = rng.standard_normal((n, n))
    return root @ root.T + 0.1 * np.eye(n)


@MODERATE
@given(seed=st.integers(0, 2**32 - 1), n=st.sampled_from([6, 10]), m=st.integers(1, 6))
def test_a_step_is_filterpys(seed, n, m):
    rng = np.random.default_rng(seed)
    x, P, R, Q = rng.standard_normal(n), _covariance(rng, n), _covariance(rng, m), _covariance(rng, n)
    F, H, z = rng.standard_normal((n, n)), rng.standard_normal((m, n)), rng.standard_normal(m)
    reference = ExtendedKalmanFilter(dim_x=n, dim_z=m)
    reference.x, reference.P, reference.F, reference.Q = x.copy(), P.copy(), F, Q
    reference.predict()
    x, P = predicted(x, P, F, Q)
    np.testing.assert_allclose(x, reference.x, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(P, reference.P, rtol=1e-9, atol=1e-9)
    reference.update(z, HJacobian=lambda _x: H, Hx=lambda x: H @ x, R=R)
    x, P, precision = updated(x, P, z - H @ x, H, R)
    scale = np.abs(reference.P).max()
    np.testing.assert_allclose(x, reference.x, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(P, reference.P, rtol=1e-6, atol=1e-8 * scale)
    np.testing.assert_allclose(precision, reference.SI, rtol=1e-6, atol=1e-8)


@MODERATE
@given(seed=st.integers(0, 2**32 - 1))
def test_a_measurement_takes_uncertainty_and_changes_nothing_that_was_given(seed):
    rng = np.random.default_rng(seed)
    x, P, R, H = rng.standard_normal(6), _covariance(rng, 6), _covariance(rng, 3), rng.standard_normal((3, 6))
    given_x, given_P = x.copy(), P.copy()
    _, after, _ = updated(x, P, rng.standard_normal(3), H, R)
    assert np.trace(after) <= np.trace(P) + 1e-9
    assert np.linalg.eigvalsh(after).min() > 0.0
    np.testing.assert_array_equal(x, given_x)
    np.testing.assert_array_equal(P, given_P)


def test_no_information_changes_nothing():
    rng = np.random.default_rng(1)
    x, P = rng.standard_normal(6), _covariance(rng, 6)
    after_x, after, _ = updated(x, P, np.array([5.0]), np.zeros((1, 6)), np.eye(1))
    assert after_x == pytest.approx(x)
    np.testing.assert_allclose(after, P)
