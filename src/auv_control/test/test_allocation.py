"""Claims about allocators, on the thrusters of both presets that have them."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

import auv_core.models
from auv_control.allocation import make_allocator, qp
from auv_control.allocation._linear import put_clipped_forces, put_scaled_forces
from auv_control.thruster_computer import put_demands
from auv_core.compiled import _compiled
from auv_core.params import load, load_section
from auv_core.plugins import list_plugins
from auv_core.thrusters import Thrusters, axis_maxima

EFFORT = 1e-6
KINDS = list_plugins("auv_control.allocation")


def _thrusters_of(preset):
    path = Path(str(auv_core.models.__file__)).parent / f"presets/{preset}.yaml"
    return load(Thrusters, yaml.safe_load(path.read_text(encoding="utf-8"))["params"]["thrusters"], preset)


VEHICLES = {preset: _thrusters_of(preset) for preset in ("odin", "bluerov2_heavy")}
every_vehicle = pytest.mark.parametrize("thrusters", VEHICLES.values(), ids=VEHICLES)
vehicles = st.sampled_from(list(VEHICLES.values()))
losses = st.sampled_from([(), (1,), (6,), (1, 2), (4, 8)])
directions = st.tuples(*[st.floats(-1.0, 1.0)] * 6)


def _allocator(kind, thrusters, lost=()):
    return make_allocator(load_section({"kind": kind}, kind, "auv_control.allocation"), thrusters, lost)


def _weights(thrusters):
    return np.array([1.0] * 3 + [1.0 / thrusters.moment_arm_m] * 3)


def _largest(thrusters):
    T, lowest_n, highest_n = thrusters.matrix(), thrusters.lowest_n, thrusters.highest_n
    return axis_maxima(T, lowest_n, highest_n).min(axis=1)


def _objective(thrusters, lost, forces, tau):
    error = _weights(thrusters) * (thrusters.matrix(lost) @ forces - tau)
    return error @ error + EFFORT * np.dot(forces, forces)


def _reference(thrusters, lost, tau):
    """Return what scipy finds, with the lost thrusters taken out."""
    kept = [k for k in range(thrusters.count) if k + 1 not in lost]
    weights = _weights(thrusters)
    rows = np.vstack([weights[:, None] * thrusters.matrix()[:, kept], EFFORT**0.5 * np.eye(len(kept))])
    goal = np.concatenate([weights * tau, np.zeros(len(kept))])
    limits = thrusters.lowest_n[kept], thrusters.highest_n[kept]
    forces = np.zeros(thrusters.count)
    forces[kept] = lsq_linear(rows, goal, limits, method="bvls", tol=1e-15).x
    return forces


@given(vehicles, losses, directions, st.sampled_from(KINDS))
def test_forces_lie_within_the_limits_and_lost_thrusters_rest(thrusters, lost, direction, kind):
    tau = 1.5 * _largest(thrusters) * direction
    forces = _allocator(kind, thrusters, lost).forces_n(tuple(tau.tolist()))
    assert all(thrusters.lowest_n <= forces)
    assert all(forces <= thrusters.highest_n)
    assert all(forces[number - 1] == 0.0 for number in lost)


@given(vehicles, directions)
def test_scaling_keeps_the_direction_of_the_wrench(thrusters, direction):
    tau = 1.5 * _largest(thrusters) * direction
    given_tau = thrusters.matrix() @ _allocator("pinv_scale", thrusters).forces_n(tuple(tau.tolist()))
    share = given_tau @ tau / (tau @ tau) if tau @ tau > 0.0 else 1.0
    assert share <= 1.0 + 1e-9
    np.testing.assert_allclose(given_tau, share * tau, atol=1e-9 * (1.0 + np.abs(tau).max()))


@given(vehicles, losses, directions)
def test_the_quadratic_program_is_never_worse_than_clipping_or_scaling(thrusters, lost, direction):
    tau = 1.5 * _largest(thrusters) * direction
    costs = {
        kind: _objective(
            thrusters, lost, _allocator(kind, thrusters, lost).forces_n(tuple(tau.tolist())), tau
        )
        for kind in KINDS
    }
    assert costs["qp"] <= min(costs.values()) + 1e-9 * costs["qp"]


@given(vehicles, losses, directions)
def test_the_quadratic_program_agrees_with_scipy(thrusters, lost, direction):
    tau = 1.5 * _largest(thrusters) * direction
    forces = _allocator("qp", thrusters, lost).forces_n(tuple(tau.tolist()))
    np.testing.assert_allclose(forces, _reference(thrusters, lost, tau), atol=1e-6)


@every_vehicle
def test_of_a_thousand_wrenches_the_program_misses_less(thrusters):
    """
    In the mean over wrenches that saturate a least-norm solution, the program's error is at most 0.6 of
    clipping's. On the others it is the least-norm solution, to 1e-6 of a thruster's range.
    """
    wrenches = 0.27 * _largest(thrusters) * np.random.default_rng(15).standard_normal((1000, 6))
    least_norm = wrenches @ np.linalg.pinv(thrusters.matrix()).T
    outside = (least_norm < thrusters.lowest_n) | (least_norm > thrusters.highest_n)
    is_saturated = outside.any(axis=1)
    assert 0.12 < is_saturated.mean() < 0.25
    forces = {
        kind: np.array([_allocator_of.forces_n(tuple(tau)) for tau in wrenches.tolist()])
        for kind, _allocator_of in ((kind, _allocator(kind, thrusters)) for kind in KINDS)
    }
    errors = {
        kind: np.linalg.norm(_weights(thrusters) * (f @ thrusters.matrix().T - wrenches), axis=1)
        / np.linalg.norm(_weights(thrusters) * wrenches, axis=1)
        for kind, f in forces.items()
    }
    mean = {kind: error[is_saturated].mean() for kind, error in errors.items()}
    assert mean["qp"] <= 0.6 * mean["pinv_clip"]
    assert mean["pinv_clip"] < mean["pinv_scale"]
    for kind in KINDS:
        np.testing.assert_allclose(
            forces[kind][~is_saturated],
            least_norm[~is_saturated],
            atol=1e-6 * thrusters.highest_n.max(),
        )


@given(vehicles, directions, st.sampled_from([(), (2,), (7,)]))
def test_after_a_known_loss_what_can_be_reached_is_reached(thrusters, direction, lost):
    left = axis_maxima(thrusters.matrix(lost), thrusters.lowest_n, thrusters.highest_n).min(axis=1)
    tau = left * direction / max(1e-9, np.abs(direction).sum())
    given_tau = thrusters.matrix(lost) @ _allocator("qp", thrusters, lost).forces_n(tuple(tau.tolist()))
    np.testing.assert_allclose(given_tau, tau, atol=1e-5 * np.abs(left).max())


@every_vehicle
def test_compiled_allocators_give_the_same_to_the_last_bit(thrusters):
    wrenches = 0.5 * _largest(thrusters) * np.random.default_rng(4).standard_normal((200, 6))
    for kind in KINDS:
        plain, compiled = _allocator(kind, thrusters), _allocator(kind, thrusters)
        function = {
            "pinv_clip": put_clipped_forces,
            "pinv_scale": put_scaled_forces,
            "qp": qp.put_nearest_forces,
        }[kind]
        compiled._put = _compiled(function)
        for tau in map(tuple, wrenches.tolist()):
            assert plain.forces_n(tau) == compiled.forces_n(tau)


def test_compiled_demands_are_the_same_to_the_last_bit():
    rng, compiled = np.random.default_rng(8), _compiled(put_demands)
    for _ in range(50):
        rows, limits = rng.uniform(-40.0, 40.0, (2, 8)), np.array([[-25.0] * 8, [30.0] * 8])
        ours = rows.copy()
        put_demands(ours, limits, 0.6065306597)
        compiled(rows, limits, 0.6065306597)
        np.testing.assert_array_equal(ours, rows)
