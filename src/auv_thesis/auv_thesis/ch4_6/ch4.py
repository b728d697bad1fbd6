"""
Chapter 4: three spheres steer to a ring between two cylinders, thesis Figs 4.5-4.6 and Table 4.1.

The thesis gives neither the starts nor the gains of the layers around a vehicle, nor a number to compare
with. Its claims are judged from our own default case, from ablations and from random starts.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import legend_below
from auv_experiment.figures.region import plot_tracks_in_space, vehicle_handles
from auv_experiment.metrics import region as metrics_region
from auv_experiment.metrics.distances import vehicle_pairs
from auv_thesis.items import (
    AGREES,
    DIFFERS,
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Claim,
    Figure,
    Row,
    Run,
    RunSpec,
    Table,
    Verdict,
)

STARTS = 30
"""Random starts per set of layer gains."""
STARTS_SEED = 0
APPROACH_S = 12.0
"""Vehicles from the corners meet within this time (s) or never."""
_COARSE = ("dt_s=0.02", "period_s=0.02")
_PRINTED = "agent.controller.params.layer_gains_pm3=[0.1,0.1]"
_NO_G = "agent.controller.params.gravity_compensation=false"
_X, _Y, _Z = (5.0, 20.0), (0.0, 20.0), (0.0, 20.0)


def _from(starts: Any) -> tuple[str, ...]:
    return tuple(f"vehicles.{i}.position_ned_m={list(start)}" for i, start in enumerate(starts))


def corner_starts(seed: int, count: int) -> list[tuple[str, ...]]:
    """Return overrides for `count` groups that start within 2 m of three corners of the thesis's plot box."""
    rng = np.random.default_rng(seed)
    groups = []
    for _ in range(count):
        group = []
        for corner in rng.permutation(8)[:3]:
            ends = [limits[corner >> bit & 1] for bit, limits in enumerate((_X, _Y, _Z))]
            inward = [-1.0 if end > 10.0 else 1.0 for end in ends]
            jitter_m = rng.uniform(0.0, 2.0, 3)
            group.append(
                [round(e + s * j, 3) for e, s, j in zip(ends, inward, jitter_m.tolist(), strict=True)]
            )
        groups.append(_from(group))
    return groups


DEFAULT = RunSpec("ch4_region")
LIMITED = RunSpec("ch4_region_limited", _COARSE)
PRINTED = RunSpec("ch4_region", (*_COARSE, _PRINTED))
OTHER_CASE = RunSpec(
    "ch4_region", (*_COARSE, _PRINTED, *_from([(20.0, 20.0, 20.0), (5.0, 0.0, 0.0), (20.0, 0.0, 5.0)]))
)
NO_COMPENSATION = RunSpec("ch4_region", (*_COARSE, _PRINTED, _NO_G))
_GROUPS = corner_starts(STARTS_SEED, STARTS)
RANDOM = tuple(RunSpec("ch4_region", (*_COARSE, *group), APPROACH_S) for group in _GROUPS)
RANDOM_PRINTED = tuple(RunSpec("ch4_region", (*_COARSE, _PRINTED, *group), APPROACH_S) for group in _GROUPS)


def _draw_tracks(canvas: Canvas, runs: list[Run], elevation_deg: float) -> None:
    """Draw tracks and ring in the thesis's axes: x, y and z as numbers, z upwards."""
    run = runs[0]
    ring = metrics_region.ring_of(run.scenario)
    if ring is None:
        raise ValueError("the run has no ring to steer to")
    canvas.set_layout_engine("none")
    canvas.set_size_inches(6.5, 5.2)
    axes: Any = canvas.add_axes((0.02, 0.12, 0.92, 0.86), projection="3d")
    plot_tracks_in_space(axes, run.recording, ring, (0, 1, 2))
    axes.set_xlim(_X)
    axes.set_ylim(_Y)
    axes.set_zlim(_Z)
    for axis, word in ((axes.xaxis, "X"), (axes.yaxis, "Y"), (axes.zaxis, "Z")):
        axis.set_ticks([5, 10, 15, 20] if word == "X" else [0, 5, 10, 15, 20])
        axis.set_label_text(f"position along {word} axis (m)")
    axes.view_init(elev=elevation_deg, azim=-52.0)
    legend_below(canvas, vehicle_handles(run.recording))


def _draw_side(canvas: Canvas, runs: list[Run]) -> None:
    _draw_tracks(canvas, runs, 14.0)


def _draw_top(canvas: Canvas, runs: list[Run]) -> None:
    _draw_tracks(canvas, runs, 62.0)


def _table_4_1(runs: list[Run]) -> list[Row]:
    hull: Any = runs[0].scenario.vehicles[0].model.params
    law: Any = runs[0].scenario.agent.controller.params
    gravity_mps2 = hull.weight_n / hull.mass_kg
    volume_m3 = 4.0 / 3.0 * math.pi * hull.hull_radius_m**3
    density_kgpm3 = hull.buoyancy_n / (gravity_mps2 * volume_m3)
    displaced_kg = hull.buoyancy_n / gravity_mps2
    heavy = (
        f"the sphere displaces {displaced_kg:.1f} kg, so it is {hull.weight_n - hull.buoyancy_n:.1f} N "
        "heavy; the law compensates for that"
    )
    gains = ", ".join(f"{gain:g}" for gain in law.layer_gains_pm3)
    return [
        _parameter("mass of ODIN", "125 kg", 125.0, hull.mass_kg, "kg"),
        _parameter("radius of ODIN", "0.3 m", 0.3, hull.hull_radius_m, "m", heavy),
        _parameter("distance of CM from CG", "0.05 m", 0.05, hull.cog_z_m, "m", "interpreted as CM from CB"),
        _parameter("density of water", "1000 kg/m^3", 1000.0, density_kgpm3, "kg/m^3"),
        _parameter("gravity", "9.81 m/s^2", 9.81, gravity_mps2, "m/s^2"),
        _parameter("ring: inner radius", "0.3 m", 0.3, law.inner_radius_m, "m"),
        _parameter("ring: outer radius", "2.5 m", 2.5, law.outer_radius_m, "m"),
        _parameter("ring: height", "1 m", 1.0, law.height_m, "m"),
        _parameter("k_p", "55", 55.0, law.force_gain_n, "N"),
        _parameter("k_l", "0.1", 0.1, law.region_gain_pm3, "1/m^3"),
        _parameter("K_v", "30", 30.0, law.damping_gain[0], "N s/m"),
        Row("gains of the layers", "not given", f"{gains} 1/m^3", NO_NUMBER, "ours, from random starts"),
        Row("added mass", "not given", f"{hull.added_mass[0]:g} kg", NO_NUMBER, "ODIN in the literature"),
        Row(
            "quadratic drag",
            "not given",
            f"{hull.quadratic_damping[0]:g} N s^2/m^2",
            NO_NUMBER,
            "ODIN in the literature",
        ),
    ]


def _parameter(quantity: str, printed: str, value: float, ours: float, unit: str, note: str = "") -> Row:
    return Row(
        quantity, printed, f"{ours:g} {unit}", AGREES if abs(ours - value) < 1e-6 * value else DIFFERS, note
    )


def _case_rows(runs: list[Run]) -> list[Row]:
    names = (
        "default case, layers 100 and 500",
        "default case, layers 0.1 and 0.1",
        "other starts, layers 0.1 and 0.1",
        "default case, steering bounded to 200 N",
        "default case, 0.1 and 0.1, no gravity compensation",
    )
    rows = []
    for name, run in zip(names, runs, strict=True):
        numbers = run.metrics
        rows.append(_closest_row(name, run))
        rows.append(
            Row(
                f"{name}: last to arrive",
                "arrives, no time given",
                _reached_words(numbers["ring_reached_s"]),
                AGREES if None not in numbers["ring_reached_s"] else DIFFERS,
                f"within {metrics_region.REACHED_M:g} m of the ring to the end of the run",
            )
        )
        rows.append(
            Row(
                f"{name}: largest demand on a vehicle",
                "not given",
                f"{numbers['force_max_n']:.0f} N, {numbers['speed_max_mps']:.1f} m/s",
                NO_NUMBER,
            )
        )
    return rows


def _closest_row(name: str, run: Run) -> Row:
    closest_m, at_s = run.metrics["pair_distance_min_m"], run.metrics["pair_distance_min_at_s"]
    touch_m = 2.0 * run.scenario.hull_radius_m
    collides = closest_m < touch_m
    return Row(
        f"{name}: smallest distance",
        "no collision",
        f"{closest_m:.3f} m at {at_s:.2f} s",
        DIFFERS if collides else AGREES,
        f"hulls touch at {touch_m:g} m",
    )


def _reached_words(reached_s: list[float | None]) -> str:
    if None in reached_s:
        return "never in this run"
    return " / ".join(f"{value:.2f}" for value in reached_s if value is not None) + " s"


def _judge_arrival(runs: list[Run]) -> Verdict:
    parts, arrived = [], 0
    for run, name in zip(runs, ("default case", "200 N"), strict=True):
        reached_s = run.metrics["ring_reached_s"]
        arrived += None not in reached_s
        most = f"{run.metrics['force_max_n'] / 1e3:.1f} kN and {run.metrics['speed_max_mps']:.1f} m/s at most"
        parts.append(f"{name}: all permanently in the ring after {_reached_words(reached_s)}, {most}")
    return Verdict((DOES_NOT_HOLD, HOLDS_IN_PART, HOLDS)[arrived], "; ".join(parts))


def _judge_collisions(runs: list[Run]) -> Verdict:
    default, others = runs[0], runs[1:]
    ours, printed = others[:STARTS], others[STARTS:]
    closest_m = [run.metrics["pair_distance_min_m"] for run in ours]
    hits, printed_hits = (sum(run.metrics["collision"] for run in group) for group in (ours, printed))
    evidence = (
        f"default case: at least {default.metrics['pair_distance_min_m']:.3f} m between centres. From "
        f"{STARTS} random starts near corners of the plotted box: {hits} collide with layers 100 and 500 (at "
        f"least {min(closest_m):.3f} m apart), {printed_hits} with 0.1 and 0.1, the only printed candidate"
    )
    if default.metrics["collision"]:
        return Verdict(DOES_NOT_HOLD, evidence)
    return Verdict(HOLDS if hits + printed_hits == 0 else HOLDS_IN_PART, evidence)


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


_SHOWS = (
    "In the thesis three vehicles start at three sides of a box of 15 m by 20 m by 20 m and end near (10, "
    "10, 10). The starts are not given, so ours are on faces and edges of that box. The ring is drawn to "
    "scale, and z points upwards as in the thesis. Our vehicles overshoot the ring before they return to "
    "stay."
)

FIGURES = (
    Figure("4.5", "Three vehicles steer to the safe region, from the side", (DEFAULT,), _draw_side, _SHOWS),
    Figure("4.6", "Three vehicles steer to the safe region, from above", (DEFAULT,), _draw_top, _SHOWS),
)

TABLES = (
    Table("4.1", "Parameters of ODIN, of the ring and of the law", (DEFAULT,), _table_4_1),
    Table(
        "4.A",
        "Cases: nearest pair, arrival, demand",
        (DEFAULT, PRINTED, OTHER_CASE, LIMITED, NO_COMPENSATION),
        _case_rows,
    ),
)

CLAIMS = (
    Claim("4.6", "The vehicles steer to the safe region.", (DEFAULT, LIMITED), _judge_arrival),
    Claim(
        "4.6",
        "On their way they do not collide with each other.",
        (DEFAULT, *RANDOM, *RANDOM_PRINTED),
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
