"""Descriptions of the metrics, for the terminal, the report, sweeps and the docs."""

from __future__ import annotations

import re

from auv_experiment.metrics import Meaning
from auv_experiment.metrics.windows import AGES_S, age_words


def _share(words: str, digits: int = 3) -> Meaning:
    return Meaning("", words, digits, is_share=True)


def _tails() -> dict[str, Meaning]:
    """Return the meanings of `neighbours.tail_metrics`."""
    meanings = {}
    for name, percent, expected in (("95", "95", 0.05), ("997", "99.7", 0.003)):
        key = f"neighbour_nees_beyond_{name}"
        words = f"share of squared errors of neighbours beyond the {percent} % point"
        for index, low_s in enumerate(AGES_S):
            meanings[f"{key}_age_{low_s}s_ratio"] = _share(
                f"{words}, packet {age_words(index)} old ({expected:g} expected)", 4
            )
        meanings[f"{key}_first_minute_ratio"] = _share(
            f"{words}, in the first minute ({expected:g} expected)", 4
        )
    return meanings


OF_LAWS = {
    # courses
    "heading_settling_1deg_s": Meaning(
        "s", "time after which the heading stays within 1 degree of the course", 1
    ),
    "heading_overshoot_rad": Meaning(
        "rad", "largest heading error beyond the course after the largest error", 4
    ),
    "depth_settling_0p2m_s": Meaning("s", "time after which the depth stays within 0.2 m of the course", 1),
    "depth_overshoot_m": Meaning("m", "largest depth error beyond the course after the largest error", 3),
    "cross_track_rms_m": Meaning(
        "m", "distance beside the path or lane, rms after 150 s or formation; the worst vehicle"
    ),
    "cross_track_max_m": Meaning("m", "largest distance beside the path or lane after 150 s or formation"),
    "fin_effort_rad2s": Meaning("rad² s", "integral of the squared angles of the fins, all vehicles", 3),
    "propeller_turns": Meaning("", "turns of all propellers", 1),
    # fleets
    "fleet_formed_at_s": Meaning("s", "first time at which all vehicles are in formation", 1),
    "coordination_error_p95_m": Meaning(
        "m", "largest difference of two path parameters, 95th percentile from the time of formation on"
    ),
    "coordination_error_after_700s_p95_m": Meaning(
        "m", "largest difference of two path parameters, 95th percentile after 700 s"
    ),
    "packets_per_minute": Meaning(
        "1/min", "packets of the whole fleet per minute, from the time of formation on", 2
    ),
    "packets_per_minute_after_700s": Meaning("1/min", "packets of the whole fleet per minute after 700 s", 2),
    "pair_distance_working_min_m": Meaning("m", "smallest distance of two vehicles that work"),
    "wreck_distance_min_m": Meaning("m", "smallest distance of a vehicle that works from one that does not"),
    "turn_away_ratio": Meaning("", "share of the way to the lanes on which vehicles turn away from others"),
    # paths
    "position_rms_m": Meaning("m", "distance to the path, rms over the run; the worst vehicle", 4),
    "position_rms_after_30s_m": Meaning("m", "distance to the path, rms from 30 s on; the worst vehicle", 4),
    "position_err_max_m": Meaning("m", "largest distance to the path after 30 s", 4),
    "overshoot_x_m": Meaning("m", "largest north error (path minus position) before 30 s", 4),
    "undershoot_y_m": Meaning("m", "smallest east error (path minus position) before 30 s", 4),
    "velocity_err_x_peak_mps": Meaning("m/s", "largest north error of the velocity", 4),
    "velocity_err_y_peak_mps": Meaning("m/s", "largest east error of the velocity", 4),
    "x_settling_0p1m_s": Meaning("s", "time after which the north error stays below 0.1 m", 2),
    "y_settling_0p2m_s": Meaning("s", "time after which the east error stays below 0.2 m", 2),
    "y_settling_0p1m_s": Meaning("s", "time after which the east error stays below 0.1 m", 2),
    "position_settling_0p1m_s": Meaning(
        "s", "time after which the distance to the path stays below 0.1 m", 2
    ),
    "velocity_settling_0p01mps_s": Meaning(
        "s", "time after which the north and east errors of the velocity stay below 0.01 m/s", 2
    ),
    "control_effort_n2s": Meaning("N² s", "integral of the squared commanded force, all vehicles", 1),
    "obstacle_clearance_m": Meaning("m", "smallest distance of a hull centre to each obstacle's centre"),
    "obstacle_closest_at_s": Meaning("s", "time of the smallest distance to each obstacle", 1),
    # adaptive formation
    "position_err_range_m": Meaning(
        "m", "smallest and largest path error of the first vehicle, over x, y, z and yaw (rad)"
    ),
    "velocity_err_range_mps": Meaning("m/s", "smallest and largest rate of that error, yaw in rad/s"),
    "force_range_n": Meaning("N", "smallest and largest commanded force of the first vehicle, yaw in N m", 1),
    **{
        f"{axis}_settling_0p05_s": Meaning(
            "s", f"time after which the {axis} error of the first vehicle stays within 0.05 {unit}", 2
        )
        for axis, unit in (("x", "m"), ("y", "m"), ("z", "m"), ("yaw", "rad"))
    },
    **{
        f"{axis}_overshoot_{unit}": Meaning(
            unit, f"largest {axis} error of the first vehicle on the other side than at the start", 4
        )
        for axis, unit in (("x", "m"), ("y", "m"), ("z", "m"), ("yaw", "rad"))
    },
    **{
        f"{axis}_force_late_n": Meaning(
            "N", f"largest commanded {axis} force of the first vehicle after 100 s"
        )
        for axis in "xyz"
    },
    **{
        f"{pair}_{what}": Meaning(unit, words.format(pair=f"vehicles {pair[1]} and {pair[2]}"), digits)
        for pair in ("d12", "d23")
        for what, unit, words, digits in (
            ("range_m", "m", "smallest and largest signed distance of {pair} from the vertical axis", 3),
            (
                "settling_0p05_s",
                "s",
                "time after which the signed distance of {pair} is within 0.05 m of that of their paths",
                2,
            ),
            (
                "err_late_m",
                "m",
                "largest error of the signed distance of {pair} after 100 s",
                4,
            ),
            ("true_range_m", "m", "smallest and largest distance of the hull centres of {pair}", 3),
        )
    },
    "d12_minus_d23_range_m": Meaning("m", "smallest and largest difference of the two signed distances"),
    "d12_minus_d23_final_m": Meaning("m", "difference of the two signed distances at the end", 4),
    "d12_minus_d23_late_m": Meaning("m", "largest difference of the two signed distances after 100 s", 4),
    "estimate_names": Meaning("", "names of the law's parameter estimates"),
    "estimates_final": Meaning("", "parameter estimates of each vehicle at the end, in that order"),
    "adaptation_frozen_s": Meaning(
        "s", "time in which the law's force limit held the parameter estimates, summed over the vehicles", 1
    ),
    # formations with slots
    "formation_error_rms_m": Meaning(
        "m", "distance of vehicles from their slots relative to the leader, rms, from the formation on"
    ),
    "formation_error_final_m": Meaning(
        "m", "largest distance of a live vehicle from its slot, relative to the leader, at the end"
    ),
    "formation_in_place_after_s": Meaning(
        "s", "time after which every live vehicle stays within 0.5 m of its slot, relative to the leader", 1
    ),
    "formation_agreed_after_s": Meaning(
        "s", "time after which all live vehicles hold the same slots, those that follow from the losses", 1
    ),
    "string_gain_max": Meaning(
        "", "largest spacing error of a vehicle / that of the one that it follows, in a fixed formation"
    ),
    "string_gain_l2_max": Meaning(
        "", "string_gain_max with the L2 norms of the errors instead of their largest values"
    ),
    "string_gain_leader_max": Meaning(
        "", "largest spacing error of a follower / error of the leader on its path, in a fixed formation"
    ),
    "mesh_gain_max": Meaning(
        "", "largest spacing error of a layer / that of the layer ahead of it, in a fixed formation"
    ),
    "leader_to_formation_gain_s": Meaning(
        "s", "largest stacked error of the followers per change of the path's speed, in a fixed formation"
    ),
    # regions
    "ring_first_inside_s": Meaning("s", "first time of each vehicle inside the ring", 1),
    "ring_reached_s": Meaning(
        "s", "time after which each vehicle stays within 0.05 m of the ring, inside it included", 1
    ),
    "ring_distance_final_m": Meaning("m", "distance of each vehicle to the ring at the end, 0 inside"),
    "axis_distance_final_m": Meaning("m", "distance of each vehicle to the ring's axis at the end"),
    "position_final_ned_m": Meaning("m", "position of each vehicle at the end (north, east, down)"),
    "speed_max_mps": Meaning("m/s", "largest speed of any vehicle"),
    "force_max_n": Meaning("N", "largest commanded force of any vehicle", 1),
    # the thesis's bound on the consensus error
    "consensus_rho_mps": Meaning("m/s", "largest disturbance of the consensus filters (rho of Eq. 6.18)", 4),
    "consensus_rho_settled_mps": Meaning(
        "m/s", "largest disturbance of the consensus filters after 100 s (rho of Eq. 6.18)", 4
    ),
    "consensus_bound_holds": Meaning(
        "", "the bound of Eq. (6.18) on the consensus error holds in the whole run"
    ),
    "consensus_bound_margin_m2ps": Meaning("m²/s", "smallest margin to the bound of Eq. (6.18)", 4),
    "consensus_bound_radius_settled_m": Meaning(
        "m", "largest consensus error, over all vehicles, that Eq. (6.18) allows after 100 s", 4
    ),
    "consensus_error_norm_settled_m": Meaning(
        "m", "largest consensus error, over all vehicles, after 100 s", 4
    ),
}
"""Metrics that only runs of some laws have."""

MEANINGS = {
    "pair_distance_min_m": Meaning(
        "m", "smallest distance of two hull centres at any time, lost vehicles included"
    ),
    "pair_distance_min_at_s": Meaning("s", "time of the smallest distance of two hull centres", 1),
    "formed_at_s": Meaning(
        "s",
        "end of the first 10 s in which every pair is nearer than twice the spacing of the flocking law",
        1,
    ),
    "pair_distance_formed_min_m": Meaning(
        "m", "smallest distance of a pair once the flock or fleet has formed"
    ),
    "pair_distance_formed_max_m": Meaning(
        "m", "largest distance of a pair once the flock or fleet has formed"
    ),
    "pair_distance_settled_min_m": Meaning("m", "smallest distance of a pair after 100 s", 4),
    "pair_distance_settled_max_m": Meaning("m", "largest distance of a pair after 100 s", 4),
    "pair_distance_min_after_150s_m": Meaning("m", "smallest distance of a pair after 150 s"),
    "pair_distance_max_after_200s_m": Meaning("m", "largest distance of a pair after 200 s"),
    "approach_time_2pct_s": Meaning(
        "s", "first time after which every pair stays within 2 % of its own mean over t > 20 s", 1
    ),
    "centroid_path_rms_m": Meaning("m", "distance of the vehicles' mean to the path, rms after 100 s", 4),
    "centroid_path_formed_rms_m": Meaning(
        "m", "distance of the vehicles' mean to the path, rms once the flock has formed", 4
    ),
    "consensus_error_max_m": Meaning(
        "m", "largest error of a vehicle's estimate of the flocking centre after 100 s", 4
    ),
    "obstacle_clearance_min_m": Meaning("m", "smallest distance of a hull centre to an obstacle's centre"),
    "near_pairs": Meaning("", "pairs of vehicles that came nearer than near_m of their models"),
    "near_pair_distance_min_m": Meaning("m", "smallest distance of the hull centres of these pairs"),
    "hull_in_air_ratio": _share("share of time, over all vehicles, with the whole hull above the surface"),
    "hull_in_air_height_m": Meaning("m", "largest height of a hull's lowest point above the surface", 2),
    **OF_LAWS,
    # neighbour estimates
    "neighbour_position_rmse_m": Meaning(
        "m", "error of the neighbour estimates' relative positions, rms after 100 s", 4
    ),
    "neighbour_within_2sigma_ratio": _share(
        "share of the neighbour estimates' errors within two of their standard deviations (0.954 expected)"
    ),
    "neighbour_nees_position_mean": Meaning(
        "",
        "squared error of relative positions by the filter's covariance, mean once formed (3 expected)",
        2,
    ),
    "neighbour_nees_mean": Meaning(
        "",
        "squared error of relative positions and velocities by the filter's covariance, mean once formed "
        "(6 expected)",
        2,
    ),
    "neighbour_nees_within_95_ratio": _share(
        "share of the squared errors of relative positions below their 95 % point (0.95 expected)"
    ),
    **_tails(),
    "neighbour_age_mean_s": Meaning(
        "s", "age of the newest packet in a neighbour estimate, mean after 100 s", 2
    ),
    "neighbour_age_95pct_s": Meaning(
        "s", "age of the newest packet in a neighbour estimate, 95 % are below, after 100 s", 2
    ),
    "neighbour_age_max_s": Meaning(
        "s", "age of the newest packet in a neighbour estimate, largest after 100 s", 2
    ),
    # packets
    "packets_sent": Meaning("", "packets passed to modems"),
    "packet_delivery_ratio": _share("share of the packets sent that arrived, over all other vehicles"),
    "packets_lost": Meaning("", "packets that did not reach a receiver, counted at every receiver"),
    "packet_loss_outage_ratio": _share("share of packets at their receivers lost to outage"),
    "packet_loss_noise_ratio": _share("share of packets at their receivers lost to noise"),
    "packet_loss_collision_ratio": _share(
        "share of packets at their receivers lost to collisions of packets"
    ),
    "packet_loss_half_duplex_ratio": _share("share of packets lost because their receiver was transmitting"),
    "packet_loss_range_ratio": _share("share of packets lost because their receiver was out of range"),
    "packet_delay_mean_s": Meaning("s", "start of transmission to end of reception, mean"),
    "packet_delay_95pct_s": Meaning("s", "start of transmission to end of reception, 95 % are below"),
    "packet_delay_max_s": Meaning("s", "start of transmission to end of reception, largest"),
    "acoustic_bit_rate_bps": Meaning("bit/s", "payload on the air, all modems together", 0),
    "acoustic_load_ratio": Meaning("", "time on the air, all modems together, per time of the run"),
    # who hears whom
    "graph_strongly_connected_ratio": _share(
        "share of time in which news of every vehicle can reach every other"
    ),
    "graph_connected_at_s": Meaning(
        "s", "first time at which news of every vehicle can reach every other", 0
    ),
    "graph_disconnected_at_s": Meaning("s", "first time after that at which it cannot", 0),
    "graph_parts_max": Meaning("", "largest number of groups between which no news goes both ways"),
    "graph_algebraic_connectivity_mean": Meaning(
        "", "algebraic connectivity of who hears whom, mean; N if all N vehicles hear each other", 2
    ),
    "graph_algebraic_connectivity_min": Meaning("", "algebraic connectivity of who hears whom, smallest", 2),
    "graph_degree_mean": Meaning("", "neighbours that a vehicle hears, mean", 2),
    "graph_in_degree_min": Meaning("", "fewest neighbours that any vehicle heard", 0),
    "graph_out_degree_min": Meaning("", "fewest neighbours that heard any vehicle", 0),
    "graph_window_s": Meaning("s", "age up to which a packet counts as heard", 0),
    "sonar_contacts": Meaning("", "hulls seen by sonar, all pings of all vehicles"),
    "navigation_error_rms_m": Meaning("m", "error of the navigations' own positions, rms over the run"),
    "navigation_error_final_m": Meaning("m", "error of the navigations' own positions, rms at the end"),
    "navigation_nees_mean": Meaning(
        "",
        "squared horizontal error of the navigations in units of their stated variance, mean (2 expected)",
        2,
    ),
    # the safe command
    "safe_command_ratio": _share("share of control ticks in which the safe command replaced the law's"),
    "safe_commands_stale_navigation": Meaning("", "safe commands since the navigation was too old"),
    "safe_commands_unusable_navigation": Meaning(
        "", "safe commands since the navigation had no possible state"
    ),
    "safe_commands_silent_modem": Meaning("", "safe commands since the modem was silent"),
    "safe_commands_position_beyond_the_report": Meaning(
        "", "safe commands since no report carries the position"
    ),
    "safe_commands_no_finite_command_from_the_law": Meaning("", "safe commands since the law gave no number"),
    "safe_commands_failed_computer": Meaning("", "ticks after the failure of a vehicle's computer"),
    "safe_commands_stale_command": Meaning("", "ticks in which a vehicle rested without a fresh command"),
    # the run
    "collision": Meaning("", "two hulls touched"),
    "collision_at_s": Meaning("s", "first time at which two hulls touched", 1),
    "lost_vehicles": Meaning("", "vehicles whose computer was lost"),
    "vehicles": Meaning("", "number of vehicles"),
    "duration_s": Meaning("s", "scenario time flown", 1),
    "real_time_factor": Meaning("", "simulated seconds per second of wall time", 1),
    "scenario": Meaning("", "name of the scenario"),
    "seed": Meaning("", "seed of every random number"),
    "mode": Meaning("", "how the run was driven"),
    "own_metrics_failed": Meaning("", "own metrics that failed, and why"),
}
"""Metrics by key, in the order in which they are shown."""

_V = r"(?P<flock>flock_)?lyapunov_(?P<name>\w+)"
FAMILIES = {
    rf"{_V}_falls": Meaning("", "Lyapunov candidate {name} decreases in the whole run"),
    rf"{_V}_largest_rise_ratio": Meaning(
        "", "largest increase of candidate {name} within one record / its largest value", 6
    ),
    rf"{_V}_rise_ratio": _share("share of records in which candidate {name} increases", 4),
    rf"{_V}_first_rise_s": Meaning("s", "first time at which candidate {name} increases", 1),
    r"(flock_)?lyapunov_proof_gap": Meaning("", "why the printed proof does not cover the rise"),
    r"(?P<axis>[xyz])_err_(?P<whole>\d+)p(?P<tenths>\d)_m": Meaning(
        "m", "{axis} error (path minus position) of the first vehicle at {whole}.{tenths} s", 4
    ),
}
"""Metrics whose keys hold a name or a number of the scenario, by a pattern of the key."""


def family_meaning(key: str) -> Meaning | None:
    """Return what a metric of a family says, None for another key."""
    for pattern, meaning in FAMILIES.items():
        if match := re.fullmatch(pattern, key):
            words = meaning.words.format(**match.groupdict())
            return Meaning(meaning.unit, words, meaning.digits, meaning.is_share)
    return None
