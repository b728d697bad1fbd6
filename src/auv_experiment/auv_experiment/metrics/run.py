"""
What a run amounts to in numbers.

All numbers come from recorded data alone. Symbols: K control ticks, N vehicles, P = N (N - 1) / 2 unordered
pairs; true positions in map_ned; "flock" means the vehicles whose computers are still alive.

A lost vehicle drifts on as an obstacle. It counts in `pair_distance_min_m`, `collision` and
`obstacle_clearance_min_m` to the end, and leaves every other quantity at the time of its loss: pairs and
means are then those of the vehicles that are left. A quantity that does not exist (no obstacle, no packet, a
run that ends before the time from which it counts) is None, never NaN.
"""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from auv_experiment.metrics.acoustics import acoustics_metrics, relative_position_error_ned_m
from auv_experiment.metrics.by_law import law_metrics
from auv_experiment.metrics.network import network_metrics
from auv_experiment.metrics.safety import safe_command_metrics
from auv_experiment.metrics.surface import surface_metrics
from auv_experiment.recording import FloatArray, Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

BoolArray = NDArray[np.bool_]

SETTLED_AFTER_S = 100.0
GATHERED_AFTER_S = 150.0
LATE_AFTER_S = 200.0
APPROACH_MEAN_AFTER_S = 20.0
APPROACH_BAND_RATIO = 0.02
FORMED_DISTANCE_M = 4.0
FORMED_FOR_S = 10.0
TIME_TOLERANCE_S = 1e-9

_NEIGHBOUR_METRICS = (
    "neighbour_position_rmse_m",
    "neighbour_within_2sigma_ratio",
    "neighbour_age_mean_s",
    "neighbour_age_max_s",
)


def compute_metrics(
    recording: Recording, scenario: Scenario, *, mode: str, real_time_factor: float
) -> dict[str, Any]:
    """
    Return all metrics of a run, ready for strict JSON.

    Parameters
    ----------
    recording : Recording
        What happened.
    scenario : Scenario
        What was asked for: path, obstacles, hull radius, seed, name.
    mode : str
        'lockstep', 'realtime' or 'inprocess'.
    real_time_factor : float
        Simulated seconds per second of wall time.

    Returns
    -------
    metrics : dict
        Keys carry their units. Distances are between hull centres.

        pair_distance_min_m
            smallest distance of any pair at any time, lost vehicles included;
        formed_at_s
            end of the first 10 s during which all pairs stayed under 4 m;
        pair_distance_formed_min_m, pair_distance_formed_max_m
            over all pairs of the flock for t >= formed_at_s;
        pair_distance_settled_min_m, pair_distance_settled_max_m
            over all pairs of the flock for t > 100 s;
        pair_distance_min_after_150s_m, pair_distance_max_after_200s_m
            over all pairs of the flock for t > 150 s and t > 200 s, by when any flock should have formed;
        approach_time_2pct_s
            first time after which every pair stays within 2 % of its own mean over t > 20 s;
        centroid_path_rms_m, centroid_path_rms_after_200s_m
            root mean square of |mean of true positions - path| for t > 100 s and for t > 200 s;
        consensus_error_max_m
            largest |own estimate of the centre - mean of true positions| for t > 100 s;
        obstacle_clearance_min_m
            smallest distance from a hull centre to an obstacle's centre at any time;
        hull_in_air_ratio, hull_in_air_height_m
            see `auv_experiment.metrics.surface`;
        neighbour_position_rmse_m
            root mean square of |estimate - truth|, relative to the own position as the own navigation has
            it, over ordered pairs for t > 100 s;
        neighbour_within_2sigma_ratio
            share of the components of these errors inside two of the filter's own standard
            deviations (0.954 for a consistent filter with Gaussian errors);
        neighbour_age_mean_s, neighbour_age_max_s
            age of the newest information in the estimates for t > 100 s;
        packet_delivery_ratio
            receptions / (packets sent x other vehicles alive at that time);
        packet_delay_mean_s, packet_delay_max_s
            from the start of transmission to the end of reception;
        safe_command_ratio
            share of the control ticks, over all vehicles, in which an agent gave the safe command instead of
            its law's;
        safe_commands_...
            such ticks by their cause, see `safe_command_metrics`;
        collision, collision_at_s
            whether and when two hulls first touched (distance below two hull radii).

    """
    t_s = recording.t_s
    pairs_m = pair_distances_m(recording)
    flock_pairs_m = flock_pair_distances_m(recording)
    formed_at_s = _formed_at_s(t_s, flock_pairs_m, _pair_is_gone(recording))
    formed_m = flock_pairs_m[t_s >= formed_at_s - TIME_TOLERANCE_S]
    settled_m = flock_pairs_m[_after(t_s, SETTLED_AFTER_S)]
    path_error_m = centroid_path_error_m(recording, scenario)
    ever_touching = (pairs_m < 2.0 * scenario.hull_radius_m).any(axis=1)
    lost = [recording.vehicle_ids[i] for i in np.flatnonzero(np.isfinite(recording.lost_at_s))]
    metrics: dict[str, Any] = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "mode": mode,
        "real_time_factor": real_time_factor,
        "duration_s": t_s[-1],
        "vehicles": recording.n_vehicles,
        "lost_vehicles": lost,
        "collision": bool(ever_touching.any()),
        "collision_at_s": t_s[ever_touching.argmax()] if ever_touching.any() else None,
        "pair_distance_min_m": _smallest(pairs_m),
        "formed_at_s": formed_at_s,
        "pair_distance_formed_min_m": _smallest(formed_m),
        "pair_distance_formed_max_m": _largest(formed_m),
        "pair_distance_settled_min_m": _smallest(settled_m),
        "pair_distance_settled_max_m": _largest(settled_m),
        "pair_distance_min_after_150s_m": _smallest(flock_pairs_m[_after(t_s, GATHERED_AFTER_S)]),
        "pair_distance_max_after_200s_m": _largest(flock_pairs_m[_after(t_s, LATE_AFTER_S)]),
        "approach_time_2pct_s": _approach_time_s(t_s, flock_pairs_m),
        "centroid_path_rms_m": _rms(path_error_m[_after(t_s, SETTLED_AFTER_S)]),
        "centroid_path_rms_after_200s_m": _rms(path_error_m[_after(t_s, LATE_AFTER_S)]),
        "consensus_error_max_m": _largest(consensus_error_m(recording)[_after(t_s[:-1], SETTLED_AFTER_S)]),
        "obstacle_clearance_min_m": _smallest(obstacle_distances_m(recording, scenario)),
        **surface_metrics(recording, scenario),
        **_neighbour_metrics(recording),
        **_packet_metrics(recording),
        **acoustics_metrics(recording, formed_at_s=formed_at_s),
        **network_metrics(recording, scenario),
        **safe_command_metrics(recording),
        **law_metrics(recording, scenario),
    }
    return {key: _plain(value) for key, value in metrics.items()}


def metrics_to_json(metrics: dict[str, Any]) -> str:
    """Return the metrics as strict JSON (no NaN, no Infinity), one key per line."""
    return json.dumps(metrics, indent=2, allow_nan=False) + "\n"


def vehicle_pairs(n_vehicles: int) -> list[tuple[int, int]]:
    """Return the P unordered pairs of vehicle indices (i, j), i < j, in the order of all pair arrays."""
    first, second = np.triu_indices(n_vehicles, 1)
    return list(zip(first.tolist(), second.tolist(), strict=True))


def pair_distances_m(recording: Recording) -> FloatArray:
    """Return the (K + 1, P) distances between hull centres (m), lost vehicles included."""
    first, second = np.triu_indices(recording.n_vehicles, 1)
    return _norm(recording.position_ned_m[:, first] - recording.position_ned_m[:, second])


def flock_pair_distances_m(recording: Recording) -> FloatArray:
    """Return the (K + 1, P) distances between hull centres (m), NaN from the loss of either vehicle on."""
    return np.where(_pair_is_gone(recording), np.nan, pair_distances_m(recording))


def flock_positions_ned_m(recording: Recording) -> FloatArray:
    """Return the (K + 1, N, 3) true positions (m, map_ned), NaN from a vehicle's loss on."""
    return np.where(recording.is_gone[..., np.newaxis], np.nan, recording.position_ned_m)


def centroid_ned_m(recording: Recording) -> FloatArray:
    """Return the (K + 1, 3) mean of the flock's true positions (m, map_ned), NaN where no vehicle is left."""
    positions = recording.position_ned_m
    alive = ~recording.is_gone
    total = np.where(alive[..., np.newaxis], positions, 0.0).sum(axis=1)
    count = alive.sum(axis=1)[:, np.newaxis].astype(float)
    mean: FloatArray = total / np.where(count > 0.0, count, np.nan)
    return mean


def path_ned_m(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K + 1, 3) positions eta_d of the flock's path (m, map_ned), NaN where there is none."""
    path = scenario.reference_of()
    if path is None:
        return np.full((len(recording.t_s), 3), math.nan)
    return np.array([path.at(t_s).position for t_s in recording.t_s.tolist()], dtype=np.float64)


def centroid_path_error_m(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K + 1,) distances |mean of true positions - eta_d| (m)."""
    return _norm(centroid_ned_m(recording) - path_ned_m(recording, scenario))


def consensus_error_m(recording: Recording) -> FloatArray:
    """Return the (K, N) distances |c_i - mean of true positions| (m), NaN from a vehicle's loss on."""
    error_m = _norm(recording.centre_ned_m - centroid_ned_m(recording)[:-1, np.newaxis])
    return np.where(recording.is_gone[:-1], np.nan, error_m)


def obstacle_distances_m(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K + 1, N, number of obstacles) distances from hull centres to obstacle centres (m)."""
    centres = [obstacle.position_ned_m for obstacle in scenario.environment.obstacles]
    obstacles = np.array(centres, dtype=np.float64).reshape(-1, 3)
    return _norm(recording.position_ned_m[:, :, np.newaxis] - obstacles)


def neighbour_error_ned_m(recording: Recording) -> FloatArray:
    """
    Return what every vehicle believes of where every other is relative to itself, minus the truth.

    An estimate is in the frame of the believer's own navigation, so it is compared with what that navigation
    says; with exact navigation this is the error of the position itself.

    Returns
    -------
    error : (K, N, N, 3) array
        [k, i, j] is (vehicle i's estimate of vehicle j's position - i's own believed position) - (true
        position of j - true position of i) (m, NED); NaN on the diagonal, where no estimate exists, and from
        the loss of either vehicle on.

    """
    return relative_position_error_ned_m(recording, np.arange(recording.n_ticks))


def neighbour_sigma_m(recording: Recording) -> FloatArray:
    """Return the (K, N, N, 3) standard deviations of the position estimates (m, NED), from the filters."""
    variance = np.diagonal(recording.neighbour_covariance, axis1=-2, axis2=-1)[..., :3]
    return np.sqrt(np.where(variance >= 0.0, variance, np.nan))


def link_counts(recording: Recording) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """
    Count the packets on every link.

    Returns
    -------
    expected, delivered : (N, N) arrays of int64
        [i, j] counts packets that vehicle i sent while vehicle j was alive, and those of them that
        vehicle j received. Receptions of packets that were never sent do not count.

    """
    n = recording.n_vehicles
    expected = np.zeros((n, n), dtype=np.int64)
    delivered = np.zeros((n, n), dtype=np.int64)
    if len(recording.sent) == 0 or n < 2:
        return expected, delivered
    tick, source = recording.sent[:, 0], recording.sent[:, 1] - 1
    alive = ~recording.is_gone[np.clip(tick, 0, recording.n_ticks)]
    np.add.at(expected, source, alive.astype(np.int64))
    np.fill_diagonal(expected, 0)

    row, is_known = _sent_row_of_receptions(recording)
    destination = recording.received[:, 2] - 1
    is_known &= (destination >= 0) & (destination < n)
    row, destination = row[is_known], destination[is_known]
    counts = alive[row, destination] & (source[row] != destination)
    np.add.at(delivered, (source[row][counts], destination[counts]), 1)
    return expected, delivered


def _sent_row_of_receptions(recording: Recording) -> tuple[NDArray[np.int64], BoolArray]:
    """Find for each reception the row in `sent` of its packet, and whether there is one."""
    sent_key = recording.sent[:, 1:3]
    received_key = recording.received[:, [1, 3]]
    _, key = np.unique(np.concatenate([sent_key, received_key]), axis=0, return_inverse=True)
    key = key.reshape(-1)
    row_of_key = np.full(key.max() + 1, -1, dtype=np.int64)
    row_of_key[key[: len(sent_key)]] = np.arange(len(sent_key))
    row = row_of_key[key[len(sent_key) :]]
    return row, row >= 0


def _neighbour_metrics(recording: Recording) -> dict[str, float | None]:
    if not recording.has_neighbours:
        return dict.fromkeys(_NEIGHBOUR_METRICS)
    late = _after(recording.t_s[:-1], SETTLED_AFTER_S)
    error_m = neighbour_error_ned_m(recording)[late]
    sigma_m = neighbour_sigma_m(recording)[late]
    judged = np.isfinite(error_m) & np.isfinite(sigma_m)
    inside = np.abs(error_m[judged]) <= 2.0 * sigma_m[judged]
    age_s = recording.neighbour_age_s[late][np.isfinite(error_m).all(axis=-1)]
    values = (_rms(_norm(error_m)), _mean(inside.astype(np.float64)), _mean(age_s), _largest(age_s))
    return dict(zip(_NEIGHBOUR_METRICS, values, strict=True))


def _packet_metrics(recording: Recording) -> dict[str, float | None]:
    expected, delivered = link_counts(recording)
    is_possible = expected.sum() > 0
    return {
        "packets_sent": len(recording.sent),
        "packet_delivery_ratio": delivered.sum() / expected.sum() if is_possible else None,
        "packet_delay_mean_s": _mean(recording.delay_s),
        "packet_delay_max_s": _largest(recording.delay_s),
    }


def _formed_at_s(t_s: FloatArray, flock_pairs_m: FloatArray, is_gone: BoolArray) -> float:
    """Return the end of the first FORMED_FOR_S with all pairs near (s), NaN if there is none."""
    is_near = ((flock_pairs_m < FORMED_DISTANCE_M) | is_gone).all(axis=1) & ~is_gone.all(axis=1)
    last_far = np.maximum.accumulate(np.where(is_near, -1, np.arange(len(t_s))))
    near_since_s = t_s[np.minimum(last_far + 1, len(t_s) - 1)]
    is_formed = is_near & (t_s - near_since_s >= FORMED_FOR_S - TIME_TOLERANCE_S)
    return float(t_s[is_formed.argmax()]) if is_formed.any() else math.nan


def _approach_time_s(t_s: FloatArray, flock_pairs_m: FloatArray) -> float | None:
    """Return the first time after which every pair stays within 2 % of its own late mean (s)."""
    late_m = flock_pairs_m[_after(t_s, APPROACH_MEAN_AFTER_S)]
    exists = np.isfinite(late_m)
    if not exists.any():
        return None
    count = exists.sum(axis=0)
    mean_m = np.where(exists, late_m, 0.0).sum(axis=0) / np.maximum(count, 1)
    with np.errstate(invalid="ignore"):
        is_far = np.abs(flock_pairs_m - mean_m) > APPROACH_BAND_RATIO * mean_m
    is_any_far = (is_far & (count > 0)).any(axis=1)
    if is_any_far[-1]:
        return None
    return float(t_s[len(t_s) - is_any_far[::-1].argmax()]) if is_any_far.any() else float(t_s[0])


def _pair_is_gone(recording: Recording) -> BoolArray:
    """Return (K + 1, P) flags: one vehicle of the pair has been lost by that time."""
    first, second = np.triu_indices(recording.n_vehicles, 1)
    gone = recording.is_gone
    return gone[:, first] | gone[:, second]


def _after(t_s: FloatArray, start_s: float) -> BoolArray:
    return t_s > start_s + TIME_TOLERANCE_S


def _norm(vectors: FloatArray) -> FloatArray:
    length: FloatArray = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
    return length


def _finite(values: FloatArray) -> FloatArray:
    return values[np.isfinite(values)]


def _smallest(values: FloatArray) -> float | None:
    finite = _finite(values)
    return float(finite.min()) if finite.size else None


def _largest(values: FloatArray) -> float | None:
    finite = _finite(values)
    return float(finite.max()) if finite.size else None


def _mean(values: FloatArray) -> float | None:
    finite = _finite(values)
    return float(finite.mean()) if finite.size else None


def _rms(values: FloatArray) -> float | None:
    finite = _finite(values)
    return float(np.sqrt(np.mean(finite * finite))) if finite.size else None


def _plain(value: Any) -> Any:
    """Turn NumPy scalars into Python ones and numbers that are not finite into None, in lists too."""
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
