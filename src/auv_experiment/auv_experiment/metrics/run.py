"""
All metrics of a run.

All numbers come from recorded data alone. Symbols: K control ticks, N vehicles, P = N (N - 1) / 2 unordered
pairs; true positions in map_ned; "flock" means the vehicles that are not lost. If vehicles have different
tasks, "flock" and pairs mean those that flock together, but in `collision` and `pair_distance_min_m`.

A lost vehicle drifts on as an obstacle. It counts in `pair_distance_min_m`, `collision` and
`obstacle_clearance_min_m` to the end, and in every other quantity up to its loss: pairs and means are then
those of the remaining vehicles. A quantity that does not exist (no obstacle, no packet, a run that ends
before the time from which it counts) is None, never NaN.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from auv_experiment.metrics.acoustics import acoustics_metrics
from auv_experiment.metrics.by_law import law_metrics
from auv_experiment.metrics.distances import centroid_path_error_m, consensus_error_m, obstacle_distances_m
from auv_experiment.metrics.finite import largest, plain, rms, smallest
from auv_experiment.metrics.formations.slots import formation_slot_metrics
from auv_experiment.metrics.gathering import approach_metrics, gathering_metrics
from auv_experiment.metrics.links import packet_metrics
from auv_experiment.metrics.neighbours import neighbour_metrics, tail_metrics
from auv_experiment.metrics.network import network_metrics
from auv_experiment.metrics.own import own_metrics
from auv_experiment.metrics.safety import near_metrics, safe_command_metrics, surface_metrics
from auv_experiment.metrics.windows import SETTLED_AFTER_S, TIME_TOLERANCE_S, after
from auv_experiment.recording import Recording
from auv_experiment.team_runs import TeamRun, flock_run, team_runs

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def compute_metrics(
    recording: Recording, scenario: Scenario, *, mode: str, real_time_factor: float
) -> dict[str, Any]:
    """
    Return all metrics of a run, ready for strict JSON.

    Parameters
    ----------
    recording : Recording
        The run.
    scenario : Scenario
        Its scenario: path, obstacles, hull radius, seed, name.
    mode : str
        'lockstep', 'realtime' or 'inprocess'.
    real_time_factor : float
        Simulated seconds per second of wall time.

    Returns
    -------
    metrics : dict
        By key, as `auv_experiment.metrics.descriptions` describes them. Distances are between hull centres.

    """
    t_s = recording.t_s
    runs = team_runs(recording, scenario)
    flock = flock_run(runs)
    group = TeamRun(recording, scenario) if flock is None else flock
    gathering = gathering_metrics(*group)
    formed_at_s = gathering["formed_at_s"]
    path_error_m = centroid_path_error_m(*group)
    metrics: dict[str, Any] = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "mode": mode,
        "real_time_factor": real_time_factor,
        "duration_s": t_s[-1],
        "vehicles": recording.n_vehicles,
        "lost_vehicles": [recording.vehicle_ids[i] for i in np.flatnonzero(np.isfinite(recording.lost_at_s))],
        **approach_metrics(recording, scenario),
        **gathering,
        "centroid_path_rms_m": rms(path_error_m[after(t_s, SETTLED_AFTER_S)]),
        "centroid_path_formed_rms_m": rms(path_error_m[t_s >= formed_at_s - TIME_TOLERANCE_S]),
        "consensus_error_max_m": largest(
            consensus_error_m(group.recording)[after(t_s[:-1], SETTLED_AFTER_S)]
        ),
        "obstacle_clearance_min_m": smallest(obstacle_distances_m(recording, scenario)),
        **near_metrics(recording, scenario),
        **surface_metrics(recording, scenario),
        **neighbour_metrics(recording),
        **packet_metrics(recording),
        **acoustics_metrics(recording, formed_at_s=0.0 if flock is None else formed_at_s),
        **tail_metrics(recording),
        **network_metrics(recording, scenario),
        **safe_command_metrics(recording),
        **law_metrics(runs),
        **formation_slot_metrics(*group, formed_at_s),
        **own_metrics(recording, scenario),
    }
    return {key: plain(value) for key, value in metrics.items()}


def metrics_to_json(metrics: dict[str, Any]) -> str:
    """Return the metrics as strict JSON (no NaN, no Infinity), one key per line."""
    return json.dumps(metrics, indent=2, allow_nan=False) + "\n"
