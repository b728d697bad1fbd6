"""
The thesis's proofs about a flock, as data: the bound on the consensus error, and the flock's potential.

Consensus, thesis Eqs. (6.7)-(6.18).  With e_i = c_i - mean of eta, stacked over the n vehicles,

    e_dot = -k (L + I) e + phi,   phi_i = k (eta_i - mean) - d/dt mean,
    V = |e|^2 / 2,   V_dot <= -k |e|^2 + |e| n rho,   rho >= |phi_i| for every i,

since no eigenvalue of L + I is below 1. This bounds |e| by n rho / k; it does not imply that |e| vanishes,
as the thesis concludes. rho is computed from positions and velocities, V_dot from the recorded rates of the
estimates. With delays and losses these are not consistent, and the bound can fail. Deviation: the printed
remainder of (6.13)-(6.14) lacks eta_i - mean.

Potential, thesis Eqs. (6.34)-(6.46). Candidate ``thesis`` is the printed sum of attractions and repulsions;
``corrected`` adds the term that the consensus filters minimise, k_c / 2 times the sum of |c_i - c_j|^2 over
pairs, and the path's attraction on every vehicle that is attracted. Law and filters are the negative gradient
of ``corrected``, so that it decreases for a path at rest. On a moving path the estimates do not know the
path's velocity, and neither candidate decreases in the end.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from auv_experiment.metrics.finite import norm
from auv_experiment.metrics.lyapunov import TOLERANCE_RATIO, fall_metrics
from auv_experiment.recording import FloatArray, Recording
from auv_flocking.consensus import thesis
from auv_flocking.separation import PotentialLaw, make_separation

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

SETTLED_AFTER_S = 100.0
PROOF_GAP = (
    "(6.45) leaves terms in the path's velocity without a sign, and (6.46) takes every c_i for its rate; the "
    "differences between the estimates, which the filters reduce, are not in the potential"
)


def flock_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """
    Return the thesis's bound and potential along a run.

    Returns
    -------
    metrics : dict
        As `MEANINGS` describes them, empty without a flocking law. Values are None if the law is not the
        thesis's, or a vehicle was lost. rho is the largest |phi_i|; the radius is n rho / k.

    """
    if scenario.agent.flocking is None:
        return {}
    metrics: dict[str, Any] = dict(_bound_metrics(recording, scenario))
    series = potential_series(recording, scenario)
    for name in ("thesis", "corrected"):
        metrics |= _fall_metrics(f"flock_lyapunov_{name}", series.get(name), recording.t_s)
    rose = [name for name in ("thesis", "corrected") if metrics[f"flock_lyapunov_{name}_falls"] is False]
    metrics["flock_lyapunov_proof_gap"] = PROOF_GAP if rose else None
    return metrics


def consensus_series(recording: Recording, rate_ps: float) -> dict[str, FloatArray]:
    """
    Return |e| (m), the largest |phi_i| (m/s) and V_dot (m^2/s) at every tick, each of shape (K,).

    Parameters
    ----------
    recording : Recording
        A run in which every vehicle estimates the flocking centre.
    rate_ps : float
        Rate k of the filter (1/s).

    """
    positions = recording.position_ned_m[:-1]
    mean = positions.mean(axis=1, keepdims=True)
    mean_rate = _velocity_ned_mps(recording)[:-1].mean(axis=1, keepdims=True)
    error = recording.centre_ned_m - mean
    error_rate = recording.centre_velocity_ned_mps - mean_rate
    remainder = rate_ps * (positions - mean) - mean_rate
    return {
        "error_m": np.sqrt(np.square(error).sum(axis=(1, 2))),
        "remainder_mps": np.sqrt(np.square(remainder).sum(axis=2)).max(axis=1),
        "fall_m2ps": (error * error_rate).sum(axis=(1, 2)),
    }


def bound_m2ps(error_m: FloatArray, rho_mps: float, rate_ps: float, n_vehicles: int) -> FloatArray:
    """Return the bound -k |e|^2 + |e| n rho on V_dot (m^2/s), thesis Eq. (6.18)."""
    return -rate_ps * error_m**2 + error_m * (n_vehicles * rho_mps)


def potential_series(recording: Recording, scenario: Scenario) -> dict[str, FloatArray]:
    """
    Return the flock's potential (m^2/s) at every tick by the candidate's name, each of shape (K,).

    Empty if the law is not the thesis's (a leader that steers the centre, feed-forward of the flock's
    velocity), if the separation law has no potential, or if a vehicle was lost.
    """
    flocking, separation = scenario.agent.flocking, scenario.agent.separation
    if flocking is None or separation is None or np.isfinite(recording.lost_at_s).any():
        return {}
    law = make_separation(separation)
    params = flocking.params
    is_thesis = flocking.kind == "potential" and params.leader_steers == "itself"
    if not is_thesis or params.feedforward != "leader" or not isinstance(law, PotentialLaw):
        return {}
    positions, centres = recording.position_ned_m[:-1], recording.centre_ned_m
    path = _path_ned_m(recording, scenario)
    leads = np.array([vehicle.id in scenario.leaders for vehicle in scenario.vehicles])
    feels = leads | (params.followers == "printed")
    cohesion = 0.5 * params.cohesion_gain_ps * np.square(positions - centres).sum(axis=(1, 2))
    pull = 0.5 * params.path_gain_ps * np.square(positions - path[:, np.newaxis]).sum(axis=2)
    apart = _repulsion(positions, scenario, law)
    spread = np.square(centres - centres.mean(axis=1, keepdims=True)).sum(axis=(1, 2))
    agreement = 0.5 * params.cohesion_gain_ps * recording.n_vehicles * spread
    return {
        "thesis": cohesion + pull[:, leads].sum(axis=1) + apart,
        "corrected": cohesion + pull[:, feels].sum(axis=1) + apart + agreement,
    }


def _repulsion(positions: FloatArray, scenario: Scenario, law: PotentialLaw) -> FloatArray:
    """Return the potential of all pairs, and of all vehicles with all obstacles (m^2/s), (K,)."""
    spacing_m = scenario.agent.flocking.params.spacing_m if scenario.agent.flocking else 0.0
    first, second = np.triu_indices(positions.shape[1], 1)
    total = _summed(law.potential, norm(positions[:, first] - positions[:, second]), spacing_m)
    for obstacle in scenario.environment.obstacles:
        distances_m = norm(positions - np.array(obstacle.position_ned_m))
        total = total + _summed(law.obstacle_potential, distances_m, obstacle.safety_distance_m)
    return total


def _summed(
    potential: Callable[[float, float], float], distances_m: FloatArray, spacing_m: float
) -> FloatArray:
    rows: list[list[float]] = distances_m.tolist()
    return np.array([sum([potential(distance_m, spacing_m) for distance_m in row]) for row in rows])


def _bound_metrics(recording: Recording, scenario: Scenario) -> dict[str, float | bool | None]:
    section = scenario.agent.consensus
    rate_ps = section.params.rate_ps if section and isinstance(section.params, thesis.Params) else None
    keys = (
        "consensus_rho_mps",
        "consensus_rho_settled_mps",
        "consensus_bound_holds",
        "consensus_bound_margin_m2ps",
        "consensus_bound_radius_settled_m",
        "consensus_error_norm_settled_m",
    )
    if rate_ps is None or np.isfinite(recording.lost_at_s).any():
        return dict.fromkeys(keys)
    series = consensus_series(recording, rate_ps)
    count = recording.n_vehicles
    rho_mps = float(series["remainder_mps"].max())
    bound = bound_m2ps(series["error_m"], rho_mps, rate_ps, count)
    margin_m2ps = float((bound - series["fall_m2ps"]).min())
    settled = recording.t_s[:-1] > SETTLED_AFTER_S
    late_rho_mps = float(series["remainder_mps"][settled].max()) if settled.any() else None
    late_error_m = float(series["error_m"][settled].max()) if settled.any() else None
    holds = margin_m2ps >= -TOLERANCE_RATIO * float(np.abs(bound).max())
    radius_m = None if late_rho_mps is None else count * late_rho_mps / rate_ps
    return dict(zip(keys, (rho_mps, late_rho_mps, holds, margin_m2ps, radius_m, late_error_m), strict=True))


def _fall_metrics(prefix: str, values: FloatArray | None, t_s: FloatArray) -> dict[str, float | bool | None]:
    if values is None or len(values) < 2 or not np.isfinite(values).all():
        return dict.fromkeys(fall_metrics(prefix, np.zeros((1, 1)), t_s))
    return fall_metrics(prefix, values[:, np.newaxis], t_s)


def _path_ned_m(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K, 3) points of the flock's path at the ticks (m; NED)."""
    path = scenario.reference_of()
    if path is None:
        return np.full((recording.n_ticks, 3), math.nan)
    return np.array([path.at(t_s).position for t_s in recording.t_s[:-1].tolist()], dtype=np.float64)


def _velocity_ned_mps(recording: Recording) -> FloatArray:
    """Return the (K + 1, N, 3) true velocities (m/s; NED): those of the body, rotated by the attitude."""
    scalar, vector = recording.attitude_quat_wxyz[..., :1], recording.attitude_quat_wxyz[..., 1:]
    body = recording.velocity_body[..., :3]
    across = 2.0 * np.cross(vector, body)
    velocity: FloatArray = body + scalar * across + np.cross(vector, across)
    return velocity
