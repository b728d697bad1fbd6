"""The metrics in words: unit, meaning and digits, the same for the terminal and the report."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Meaning:
    """How a metric is shown."""

    unit: str
    words: str
    digits: int = 3


MEANINGS = {
    "pair_distance_min_m": Meaning(
        "m", "smallest distance of two hull centres at any time, lost vehicles included"
    ),
    "formed_at_s": Meaning("s", "end of the first 10 s with every pair under 4 m", 1),
    "pair_distance_formed_min_m": Meaning("m", "smallest pair distance once formed"),
    "pair_distance_formed_max_m": Meaning("m", "largest pair distance once formed"),
    "pair_distance_settled_min_m": Meaning("m", "smallest pair distance after 100 s", 4),
    "pair_distance_settled_max_m": Meaning("m", "largest pair distance after 100 s", 4),
    "pair_distance_min_after_150s_m": Meaning("m", "smallest pair distance after 150 s"),
    "pair_distance_max_after_200s_m": Meaning("m", "largest pair distance after 200 s"),
    "approach_time_2pct_s": Meaning(
        "s", "after this every pair stays within 2 % of its own mean over t > 20 s", 1
    ),
    "centroid_path_rms_m": Meaning("m", "mean of the vehicles to the path, rms after 100 s", 4),
    "centroid_path_rms_after_200s_m": Meaning("m", "the same after 200 s", 4),
    "consensus_error_max_m": Meaning(
        "m", "worst estimate of the flocking centre against the true mean, after 100 s", 4
    ),
    "obstacle_clearance_min_m": Meaning("m", "smallest distance from a hull centre to an obstacle"),
    "hull_in_air_ratio": Meaning("", "share of time, over all vehicles, with the hull above the surface"),
    "hull_in_air_height_m": Meaning("m", "largest height of a hull's lowest point above the surface", 2),
    "neighbour_position_rmse_m": Meaning(
        "m", "error of what vehicles believe of each other, rms after 100 s", 4
    ),
    "neighbour_within_2sigma_ratio": Meaning(
        "", "share of these errors inside the filter's own 2-sigma band (0.954 expected)"
    ),
    "neighbour_nees_position_mean": Meaning(
        "", "squared error of relative positions in units of the filter's covariance (3 expected)", 2
    ),
    "neighbour_nees_mean": Meaning("", "the same with velocities (6 expected)", 2),
    "neighbour_nees_within_95_ratio": Meaning("", "share of the first below its 95 % point (0.95 expected)"),
    "neighbour_age_mean_s": Meaning("s", "mean age of what vehicles know of each other, after 100 s", 2),
    "neighbour_age_95pct_s": Meaning("s", "95 % of these ages are below", 2),
    "neighbour_age_max_s": Meaning("s", "largest age of it", 2),
    "packets_sent": Meaning("", "acoustic packets sent"),
    "packet_delivery_ratio": Meaning("", "receptions / (packets sent x other vehicles)"),
    "packets_lost": Meaning("", "packets that did not reach a receiver"),
    "packet_loss_outage_ratio": Meaning("", "share of packets at their receivers lost to outage"),
    "packet_loss_noise_ratio": Meaning("", "the same, to noise"),
    "packet_loss_collision_ratio": Meaning("", "the same, to collisions"),
    "packet_loss_half_duplex_ratio": Meaning("", "the same, since the receiver was sending"),
    "packet_loss_range_ratio": Meaning("", "the same, since it was out of range"),
    "packet_delay_mean_s": Meaning("s", "from the start of transmission to the end of reception, mean"),
    "packet_delay_95pct_s": Meaning("s", "the same, 95 % of packets below"),
    "packet_delay_max_s": Meaning("s", "the same, largest"),
    "acoustic_bit_rate_bps": Meaning("bit/s", "payload on the air, all modems together", 0),
    "acoustic_load_ratio": Meaning("", "time on the air, all modems together, per time of the run"),
    "graph_strongly_connected_ratio": Meaning("", "share of time in which news from all could reach all"),
    "graph_connected_at_s": Meaning("s", "first time at which it could", 0),
    "graph_disconnected_at_s": Meaning("s", "first time after that at which it could not", 0),
    "graph_parts_max": Meaning("", "largest number of groups that news can go round in"),
    "graph_algebraic_connectivity_mean": Meaning(
        "", "algebraic connectivity, mean; N if all hear each other", 2
    ),
    "graph_algebraic_connectivity_min": Meaning("", "the same, smallest", 2),
    "graph_degree_mean": Meaning("", "neighbours that a vehicle hears, mean", 2),
    "graph_in_degree_min": Meaning("", "fewest neighbours that any vehicle heard", 0),
    "graph_out_degree_min": Meaning("", "fewest neighbours that heard any vehicle", 0),
    "graph_window_s": Meaning("s", "age up to which a packet counts as heard", 0),
    "sonar_contacts": Meaning("", "hulls seen by sonar, all pings of all vehicles"),
    "navigation_error_rms_m": Meaning("m", "error of what vehicles believe of their own position, rms"),
    "navigation_error_final_m": Meaning("m", "the same at the end"),
    "navigation_nees_mean": Meaning(
        "", "squared horizontal error of it in units of the stated variance (2 expected)", 2
    ),
    "safe_command_ratio": Meaning("", "share of control ticks with the safe command in place of a law's"),
    "safe_commands_stale_navigation": Meaning("", "such ticks since the navigation was too old"),
    "safe_commands_unusable_navigation": Meaning("", "such ticks since the navigation had no possible state"),
    "safe_commands_silent_modem": Meaning("", "such ticks since the modem was silent"),
    "safe_commands_position_beyond_the_report": Meaning(
        "", "such ticks since no report carries the position"
    ),
    "safe_commands_no_finite_command_from_the_law": Meaning("", "such ticks since the law gave no number"),
    "safe_commands_stale_command": Meaning("", "ticks in which a vehicle rested without a fresh command"),
    "collision": Meaning("", "two hulls touched"),
    "collision_at_s": Meaning("s", "when they first did", 1),
    "lost_vehicles": Meaning("", "vehicles whose computer was lost"),
    "vehicles": Meaning("", "number of vehicles"),
    "duration_s": Meaning("s", "scenario time flown", 1),
    "real_time_factor": Meaning("", "simulated seconds per second of wall time", 1),
    "scenario": Meaning("", "name of the scenario"),
    "seed": Meaning("", "seed of every random number"),
    "mode": Meaning("", "how the run was driven"),
}


_UNITS = {"_bps": "bit/s", "_mps": "m/s", "_n2s": "N² s", "_m": "m", "_s": "s", "_n": "N", "_rad": "rad"}
"""Units by the ending of a name, the longer endings first."""


def shown_metrics(metrics: dict[str, Any]) -> Iterator[tuple[str, Meaning]]:
    """Yield the keys that `metrics` has, those with a known meaning first and in their order."""
    for key in [*MEANINGS, *(key for key in metrics if key not in MEANINGS)]:
        if key in metrics:
            yield key, MEANINGS.get(key) or _meaning_of_name(key)


def _meaning_of_name(key: str) -> Meaning:
    """Return what the name of a metric says by itself: its unit and its words."""
    unit = next((unit for ending, unit in _UNITS.items() if key.endswith(ending)), "")
    return Meaning(unit, key.replace("_", " "), 4)


def is_share(key: str) -> bool:
    """Tell whether a metric lies between 0 and 1 whatever happens."""
    return key.endswith("_ratio") and key in MEANINGS and key != "acoustic_load_ratio"


def value_text(value: Any, digits: int) -> str:
    """Return a metric as text; a dash for what does not exist."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.{digits}f}"
    if isinstance(value, list):
        return ", ".join(value_text(item, digits) for item in value) or "none"
    return str(value)
