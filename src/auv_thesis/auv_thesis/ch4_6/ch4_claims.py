"""The claims of chapter 4, judged from our default case, from ablations and from random starts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from auv_experiment.confidence.binomial import share_words
from auv_experiment.metrics import region as metrics_region
from auv_experiment.metrics.distances import vehicle_pairs
from auv_thesis.ch4_6.ch4 import reached_words
from auv_thesis.ch4_6.ch4_runs import (
    ARRIVED_S,
    DEFAULT,
    LIMITED,
    LIMITED_STARTS,
    LONG_STARTS,
    NO_COMPENSATION,
    PRINTED,
    RANDOM,
    RANDOM_LIMITED,
    RANDOM_LONG,
    RANDOM_PRINTED,
    STARTS,
)
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART, Claim, Run, Verdict


def _arrivals(runs: Sequence[Run]) -> int:
    return sum(None not in run.metrics["ring_reached_s"] for run in runs)


def _hits(runs: Sequence[Run]) -> int:
    return sum(bool(run.metrics["collision"]) for run in runs)


def _judge_arrival(runs: list[Run]) -> Verdict:
    """Judge arrival with whole hulls: a vehicle that has hit another is not safe in the region."""
    parts = []
    for run, name in zip(runs[:2], ("default case", "default case with 200 N"), strict=True):
        reached_s = run.metrics["ring_reached_s"]
        most = f"{run.metrics['force_max_n'] / 1e3:.1f} kN and {run.metrics['speed_max_mps']:.1f} m/s at most"
        parts.append(f"{name}: all permanently in the ring after {reached_words(reached_s)}, {most}")
    ours, limited = runs[2 : 2 + LONG_STARTS], runs[2 + LONG_STARTS : 2 + LONG_STARTS + LIMITED_STARTS]
    printed = runs[-STARTS:]
    evidence = (
        f"{'; '.join(parts)}. From random starts the whole group arrives within "
        f"{ARRIVED_S:g} s in {share_words(_arrivals(ours), LONG_STARTS)} with our layer gains, of which "
        f"{_hits(ours)} collide on the way, and in {share_words(_arrivals(limited), LIMITED_STARTS)} with "
        f"forces of at most 200 N, of which {_hits(limited)} collide. With the only printed gain "
        f"{share_words(_hits(printed), STARTS)} collide before they arrive"
    )
    unlimited = [*runs[:2], *ours]
    if _arrivals(unlimited) < len(unlimited):
        return Verdict(DOES_NOT_HOLD, evidence)
    is_whole = _arrivals(limited) == len(limited) and not _hits([*unlimited, *limited, *printed])
    return Verdict(HOLDS if is_whole else HOLDS_IN_PART, evidence)


def _judge_collisions(runs: list[Run]) -> Verdict:
    """Judge with the printed gain and with forces that a vehicle has: our gains were chosen to be safe."""
    default, others = runs[0], runs[1:]
    ours, printed, limited = others[:STARTS], others[STARTS : 2 * STARTS], others[2 * STARTS :]
    closest_m = min(run.metrics["pair_distance_min_m"] for run in ours)
    evidence = (
        f"random starts near corners of the plotted box: {share_words(_hits(printed), STARTS)} collide with "
        f"0.1 and 0.1, the only printed candidate; {share_words(_hits(limited), LIMITED_STARTS)} with forces "
        f"of at most 200 N and layers 100 and 500; {share_words(_hits(ours), STARTS)} with layers 100 and "
        f"500 and no limit (at least {closest_m:.3f} m apart), which we chose so that they do not. Default "
        f"case, ours too: at least {default.metrics['pair_distance_min_m']:.3f} m between centres"
    )
    if _hits(printed) == 0 and _hits(limited) == 0:
        return Verdict(HOLDS, evidence)
    return Verdict(HOLDS_IN_PART if _hits(printed) < STARTS else DOES_NOT_HOLD, evidence)


def _judge_layers(runs: list[Run]) -> Verdict:
    run = runs[0]
    radii_m = run.scenario.agent.controller.params.layer_radii_m
    positions = run.recording.position_ned_m
    pairs = vehicle_pairs(run.recording.n_vehicles)
    gaps_m = np.stack([np.linalg.norm(positions[:, i] - positions[:, j], axis=-1) for i, j in pairs])
    shares = [float((gaps_m.min(axis=0) < radius_m).mean()) for radius_m in radii_m]
    entered = sum(other.metrics["pair_distance_min_m"] < radii_m[-1] for other in runs[1:])
    touch_m = 2.0 * run.scenario.hull_radius_m
    evidence = (
        f"the inner layer begins at {radii_m[-1]:g} m, hulls touch at {touch_m:g} m. Default case: some pair "
        f"within the outer layer in {100 * shares[0]:.2f} % of the records, within the inner one in "
        f"{100 * shares[-1]:.2f} %; {entered} of {len(runs) - 1} random starts lead into that"
    )
    return Verdict(HOLDS if radii_m[-1] > touch_m and entered > 0 else DOES_NOT_HOLD, evidence)


def _judge_gravity(runs: list[Run]) -> Verdict:
    with_g, without = runs
    depths_m = np.array(without.metrics["position_final_ned_m"])[:, 2]
    centre_m = without.scenario.agent.controller.params.centre_ned_m[2]
    evidence = (
        f"without it all settle {np.mean(depths_m) - centre_m:.2f} m below the ring's centre "
        f"and {min(without.metrics['ring_distance_final_m']):.2f} m out of the ring; with it the last is "
        f"{max(with_g.metrics['ring_distance_final_m']):.2f} m out"
    )
    is_needed = min(without.metrics["ring_distance_final_m"]) > metrics_region.REACHED_M
    return Verdict(
        HOLDS if is_needed and None not in with_g.metrics["ring_reached_s"] else DOES_NOT_HOLD, evidence
    )


def _judge_energy(runs: list[Run]) -> Verdict:
    names = ("default case", "200 N", "no gravity compensation")
    falls = [run.metrics["lyapunov_energy_falls"] for run in runs]
    evidence = "; ".join(f"{name}: {_energy_words(run)}" for name, run in zip(names, runs, strict=True))
    return Verdict(HOLDS if all(falls) else HOLDS_IN_PART if any(falls) else DOES_NOT_HOLD, evidence)


def _energy_words(run: Run) -> str:
    if run.metrics["lyapunov_energy_falls"]:
        return "decreases in every record"
    return f"first increases at {run.metrics['lyapunov_energy_first_rise_s']:.2f} s"


CLAIMS = (
    Claim(
        "4.6",
        "The vehicles steer to the safe region.",
        (DEFAULT, LIMITED, *RANDOM_LONG, *RANDOM_LIMITED, *RANDOM_PRINTED),
        _judge_arrival,
    ),
    Claim(
        "4.6",
        "On their way they do not collide with each other.",
        (DEFAULT, *RANDOM, *RANDOM_PRINTED, *RANDOM_LIMITED),
        _judge_collisions,
    ),
    Claim(
        "4.5",
        "If the outer layer cannot avoid a collision, the inner one with its larger gain takes over.",
        (DEFAULT, *RANDOM),
        _judge_layers,
    ),
    Claim(
        "4.5",
        "The law has to compensate for weight minus buoyancy.",
        (PRINTED, NO_COMPENSATION),
        _judge_gravity,
    ),
    Claim(
        "4.5",
        "The group is stable: kinetic and potential energy together decrease (not printed; our candidate).",
        (DEFAULT, LIMITED, NO_COMPENSATION),
        _judge_energy,
    ),
)
