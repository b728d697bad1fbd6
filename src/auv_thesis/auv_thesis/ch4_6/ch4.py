"""
Chapter 4: three spheres steer to a ring between two cylinders, thesis Figs 4.5-4.6 and Table 4.1.

The thesis gives neither the starts nor the gains of the layers around a vehicle, nor a number to compare
with. `ch4_claims` judges its claims.
"""

from __future__ import annotations

import math
from typing import Any

from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import legend_below
from auv_experiment.figures.region import plot_tracks_in_space, vehicle_handles
from auv_experiment.metrics import region as metrics_region
from auv_thesis.ch4_6.ch4_runs import BOX_M, DEFAULT, LIMITED, NO_COMPENSATION, OTHER_CASE, PRINTED
from auv_thesis.items import (
    AGREES,
    DIFFERS,
    NO_NUMBER,
    Figure,
    Row,
    Run,
    Table,
)


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
    axes.set_xlim(BOX_M[0])
    axes.set_ylim(BOX_M[1])
    axes.set_zlim(BOX_M[2])
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
                reached_words(numbers["ring_reached_s"]),
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


def reached_words(reached_s: list[float | None]) -> str:
    """Return the times of arrival of all vehicles as text."""
    if None in reached_s:
        return "never in this run"
    return " / ".join(f"{value:.2f}" for value in reached_s if value is not None) + " s"


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
