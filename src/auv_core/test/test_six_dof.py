"""Claims about the equations of motion, instant by instant, on random vehicles and states."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from auv_core.geometry import ned_to_body
from auv_core.models._hull_forces import coriolis_force, damping_force, momentum
from auv_core.models.six_dof import Model, Params, constants, derivative

MODERATE = settings(max_examples=60, deadline=None)
STILL = (0.0, 0.0, 0.0)


def _six(low, high):
    return st.tuples(*[st.floats(low, high)] * 6)


VEHICLES = st.builds(
    Params,
    mass_kg=st.floats(20.0, 500.0),
    inertia_kgm2=st.tuples(*[st.floats(5.0, 50.0)] * 3),
    cog_z_m=st.floats(0.0, 0.1),
    added_mass=_six(0.0, 300.0),
    linear_damping=_six(0.0, 50.0),
    quadratic_damping=_six(0.0, 100.0),
    weight_n=st.floats(200.0, 5000.0),
    buoyancy_n=st.floats(200.0, 5000.0),
    hull_radius_m=st.floats(0.1, 1.0),
    max_wrench=_six(1.0, 300.0),
    cog_couples=st.booleans(),
)
VELOCITIES = _six(-3.0, 3.0)
WRENCHES = _six(-300.0, 300.0)
CURRENTS = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
ATTITUDES = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 4)
    .filter(lambda q: math.hypot(*q) > 1e-2)
    .map(lambda q: tuple(x / math.hypot(*q) for x in q))
)


def _skew(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def _mass_matrix(c):
    """Return M (6, 6), column by column from what `momentum` says."""
    columns = [np.concatenate(momentum(tuple(e[:3]), tuple(e[3:]), c)) for e in np.eye(6)]
    return np.array(columns).T


def _coriolis(nu, c):
    return np.concatenate(coriolis_force(tuple(nu[:3]), tuple(nu[3:]), c))


def _coupling_cog_z_m(params):
    """Return z_G as it enters M and C (m)."""
    return params.cog_z_m if params.cog_couples else 0.0


def _fossen_mass_matrices(params):
    """Return M_RB and M_A (6, 6) for the origin at the hull's centre, Fossen (2021) ch. 3 and 6."""
    S_g = _skew((0.0, 0.0, _coupling_cog_z_m(params)))
    m = params.mass_kg
    rigid_body = np.block([[m * np.eye(3), -m * S_g], [m * S_g, np.diag(params.inertia_kgm2)]])
    return rigid_body, np.diag(params.added_mass)


def _fossen_coriolis_matrix(params, nu):
    """Return C_RB(nu) + C_A(nu) (6, 6): C_RB without linear velocities in it, C_A in Lagrange's form."""
    _, M_A = _fossen_mass_matrices(params)
    m, I_b = params.mass_kg, np.diag(params.inertia_kgm2)
    S_g, S_w = _skew((0.0, 0.0, _coupling_cog_z_m(params))), _skew(nu[3:])
    C_RB = np.block([[m * S_w, -m * S_w @ S_g], [m * S_g @ S_w, -_skew(I_b @ nu[3:])]])
    linear, angular = M_A[:3, :3] @ nu[:3], M_A[3:, 3:] @ nu[3:]
    C_A = np.block([[np.zeros((3, 3)), -_skew(linear)], [-_skew(linear), -_skew(angular)]])
    return C_RB + C_A


def _fossen_acceleration(params, attitude, nu, tau, current):
    """Return nu_dot (6,) from the matrix equation of motion relative to the water."""
    R = Rotation.from_quat([*attitude[1:], attitude[0]]).as_matrix()
    water = np.concatenate([R.T @ current, np.zeros(3)])
    nu_r = nu - water
    weight = R.T @ (0.0, 0.0, params.weight_n)
    buoyancy = R.T @ (0.0, 0.0, -params.buoyancy_n)
    g = -np.concatenate([weight + buoyancy, np.cross((0.0, 0.0, params.cog_z_m), weight)])
    D = np.diag(params.linear_damping + params.quadratic_damping * np.abs(nu_r))
    M = sum(_fossen_mass_matrices(params))
    relative = np.linalg.solve(M, tau - _fossen_coriolis_matrix(params, nu_r) @ nu_r - D @ nu_r - g)
    return relative + np.concatenate([-np.cross(nu[3:], water[:3]), np.zeros(3)])


@MODERATE
@given(VEHICLES)
def test_mass_matrix_is_symmetric_and_positive_definite(params):
    M = _mass_matrix(constants(params))
    np.testing.assert_array_equal(M, M.T)
    assert np.linalg.eigvalsh(M).min() > 0.0


@MODERATE
@given(VEHICLES)
def test_mass_matrix_is_fossens(params):
    np.testing.assert_allclose(
        _mass_matrix(constants(params)), sum(_fossen_mass_matrices(params)), rtol=1e-15
    )


@MODERATE
@given(VEHICLES, VELOCITIES)
def test_coriolis_does_no_work(params, nu):
    force = _coriolis(nu, constants(params))
    assert np.dot(nu, force) == pytest.approx(0.0, abs=1e-12 * (1.0 + np.abs(force) @ np.abs(nu)))


@MODERATE
@given(VEHICLES, VELOCITIES)
def test_coriolis_is_fossens_matrix_form(params, nu):
    nu = np.array(nu)
    np.testing.assert_allclose(
        _coriolis(nu, constants(params)), _fossen_coriolis_matrix(params, nu) @ nu, rtol=1e-9, atol=1e-9
    )


@MODERATE
@given(VEHICLES, VELOCITIES)
def test_damping_only_takes_energy(params, nu):
    force = np.concatenate(damping_force(nu[:3], nu[3:], constants(params)))
    assert (np.array(nu) * force >= 0.0).all()


@MODERATE
@given(VEHICLES, ATTITUDES, VELOCITIES, WRENCHES, CURRENTS)
def test_acceleration_is_that_of_fossens_matrix_equation(params, attitude, nu, tau, current):
    rate = derivative((0.0, 0.0, 0.0, *attitude, *nu), tau, current, constants(params))
    expected = _fossen_acceleration(params, attitude, np.array(nu), np.array(tau), np.array(current))
    np.testing.assert_allclose(rate[7:], expected, rtol=1e-8, atol=1e-8)


@MODERATE
@given(VEHICLES, ATTITUDES, VELOCITIES)
def test_attitude_rate_keeps_the_quaternion_a_unit(params, attitude, nu):
    rate = derivative((0.0, 0.0, 0.0, *attitude, *nu), (0.0,) * 6, STILL, constants(params))
    assert np.dot(attitude, rate[3:7]) == pytest.approx(0.0, abs=1e-12)


@MODERATE
@given(VEHICLES, ATTITUDES, VELOCITIES)
def test_attitude_rate_is_the_body_rate(params, attitude, nu):
    rate = derivative((0.0, 0.0, 0.0, *attitude, *nu), (0.0,) * 6, STILL, constants(params))
    step_s = 1e-6
    ahead = np.array(attitude) + step_s * np.array(rate[3:7])
    turned = Rotation.from_quat([*attitude[1:], attitude[0]]).inv() * Rotation.from_quat(
        [*ahead[1:], ahead[0]]
    )
    np.testing.assert_allclose(turned.as_rotvec() / step_s, nu[3:], atol=1e-4)


@MODERATE
@given(VEHICLES, ATTITUDES, VELOCITIES)
def test_position_rate_is_the_body_velocity_in_ned(params, attitude, nu):
    north, east, down, *_ = derivative((0.0, 0.0, 0.0, *attitude, *nu), (0.0,) * 6, STILL, constants(params))
    np.testing.assert_allclose(ned_to_body(attitude, (north, east, down)), nu[:3], atol=1e-9)


@MODERATE
@given(VEHICLES, st.floats(-3.0, 3.0), st.sampled_from([0, 1]))
def test_restoring_moment_rights_the_hull(params, angle_rad, axis):
    assume(params.cog_z_m > 1e-3 and abs(math.sin(angle_rad)) > 1e-3)
    axis_vector = [angle_rad if i == axis else 0.0 for i in range(3)]
    x, y, z, w = Rotation.from_rotvec(axis_vector).as_quat()
    rate = derivative((0.0, 0.0, 0.0, w, x, y, z, *[0.0] * 6), (0.0,) * 6, STILL, constants(params))
    M = _mass_matrix(constants(params))
    moment = (M @ np.array(rate[7:]))[3 + axis]
    assert moment == pytest.approx(-params.cog_z_m * params.weight_n * math.sin(angle_rad), rel=1e-9)


@MODERATE
@given(VEHICLES, WRENCHES)
def test_actuators_give_what_is_asked_within_their_limits(params, tau):
    given_wrench = Model(params).limited_command(tau)
    np.testing.assert_array_equal(given_wrench, np.clip(tau, -np.array(params.max_wrench), params.max_wrench))


def test_a_centre_of_gravity_that_makes_the_mass_matrix_indefinite_is_refused():
    six = (1.0,) * 6
    with pytest.raises(ValueError, match=r"^cog_z_m: 0\.5 is not allowed; allowed: .*positive definite"):
        Params(100.0, (1.0, 1.0, 1.0), 0.5, six, six, six, 981.0, 981.0, 0.3, six)
    uncoupled = Params(100.0, (1.0, 1.0, 1.0), 0.5, six, six, six, 981.0, 981.0, 0.3, cog_couples=False)
    assert np.linalg.eigvalsh(_mass_matrix(constants(uncoupled))).min() > 0.0


@MODERATE
@given(VEHICLES, WRENCHES)
def test_without_limits_actuators_give_what_is_asked(params, tau):
    model = Model(replace(params, max_wrench=None))
    assert model.limited_command(tau) == tau
    assert model.top_speed_mps == math.inf
