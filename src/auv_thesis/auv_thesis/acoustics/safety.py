"""
Safety of a flock on a modem: distances and path error over slot lengths, losses, navigations and fleets.

Four numbers summarise the runs of one case: the smallest distance of any pair at any time; the smallest for
t > 150 s, when the flock has gathered; the largest for t > 200 s, each over all runs; and the 95th percentile
of the runs' rms path errors, each from the time at which its flock has formed, with its 95 % confidence
interval. Shares have 95 % exact bounds, which take runs as independent: the cells share their 100 starts.
docs/explanation/safe_flocking.md explains the law and has the whole study.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.confidence.binomial import share_words
from auv_experiment.metrics.distances import pair_distances_m
from auv_thesis.acoustics.safety_runs import (
    ABLATED,
    BARS,
    CELLS,
    DRIFT_FIXES,
    DRIFT_SONAR,
    FIXES_BARS,
    FLEETS,
    HULLS_TOUCH_M,
    N_SEEDS,
    OTHERWISE_NAVIGATED,
    OURS,
    PARTS,
    SONAR_BARS,
    THESIS,
    THESIS_LAW,
    USUAL,
    WITH_FIXES,
    WITH_SONAR,
    WORST,
    Bars,
    Cell,
    Summary,
    chosen,
    name_of,
    summary_of,
)
from auv_thesis.items import (
    AGREES,
    AGREES_IN_PART,
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

_SHOWN_SLOW = tuple(
    RunSpec("flock_modem", ("seed=3001", "acoustics.outage.params.loss_prob=0.3", *changes))
    for changes in (THESIS_LAW, ())
)


def _all(studies: Sequence[Sequence[RunSpec]]) -> tuple[RunSpec, ...]:
    return tuple(spec for specs in studies for spec in specs)


Study = dict[Cell, tuple[RunSpec, ...]]
_ALL_OURS, _ALL_THESIS, _ALL_SONAR, _ALL_FIXES = (
    _all(list(cells.values())) for cells in (OURS, THESIS, WITH_SONAR, WITH_FIXES)
)
_FULL = (*OURS[USUAL][:20], *OURS[WORST][:20])


def _row(quantity: str, runs: Sequence[Run], bars: Bars | None = None) -> Row:
    """Return a row; limits that some but not all seeds keep are kept in part."""
    if not runs:
        return Row(quantity, "not given", "not flown", NO_NUMBER, "more seeds are needed")
    summary = summary_of(runs)
    if bars is None:
        return Row(quantity, "not given", str(summary), NO_NUMBER, summary.remark)
    kept = AGREES if len(runs) == N_SEEDS else AGREES_IN_PART
    return Row(quantity, str(bars), str(summary), kept if summary.keeps(bars) else DIFFERS, summary.remark)


def _rows_of(study: Study, bars: dict[Cell, Bars], navigation: str = "") -> Callable[[list[Run]], list[Row]]:
    """Return the function that makes one row per cell of a study."""
    prefix = navigation and f"{navigation}, "

    def rows(runs: list[Run]) -> list[Row]:
        return [
            _row(prefix + name_of(cell), chosen(runs, specs), bars[cell]) for cell, specs in study.items()
        ]

    return rows


def _navigation_rows(runs: list[Run]) -> list[Row]:
    others = [
        _row(f"{name}, {name_of(USUAL)}", chosen(runs, specs)) for name, specs in OTHERWISE_NAVIGATED.items()
    ]
    return [
        *_rows_of(WITH_SONAR, SONAR_BARS, DRIFT_SONAR)(runs),
        *_rows_of(WITH_FIXES, FIXES_BARS, DRIFT_FIXES)(runs),
        *others,
    ]


def _part_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for cell in (USUAL, WORST):
        flown = {run.spec.nth // 5 for part in PARTS for run in chosen(runs, ABLATED[cell, part])}
        full = [run for run in chosen(runs, OURS[cell]) if run.spec.nth in flown]
        rows.append(_row(f"{name_of(cell)}: the law", full))
        rows += [_row(f"{name_of(cell)}: {part}", chosen(runs, ABLATED[cell, part])) for part in PARTS]
    return rows


def _fleet_rows(runs: list[Run]) -> list[Row]:
    return [
        _row(f"{n_vehicles} vehicles, {name_of(cell)}", chosen(runs, specs))
        for (n_vehicles, cell), specs in FLEETS.items()
    ]


def _draw_distances(canvas: Canvas, runs: list[Run]) -> None:
    above, below = canvas.subplots(2, 1, sharex=True)
    for axes, run, law in zip((above, below), runs, ("thesis's law", "ours"), strict=True):
        distances_m = pair_distances_m(run.recording)
        axes.fill_between(
            run.recording.t_s, distances_m.min(axis=1), distances_m.max(axis=1), color="0.8", linewidth=0.0
        )
        axes.plot(run.recording.t_s, distances_m.min(axis=1), color="black", linewidth=0.9)
        axes.axhline(HULLS_TOUCH_M, color="tab:red", linewidth=0.9)
        axes.set_ylim(0.0, 12.0)
        axes.set_ylabel(f"{law}: pairs (m)")
    below.set_xlim(0.0, 650.0)
    below.set_xlabel("t (s)")


def _draw_map(canvas: Canvas, runs: list[Run]) -> None:
    slots = sorted({cell[0] for cell in CELLS})
    losses = sorted({cell[1] for cell in CELLS})
    panels = canvas.subplots(1, 2)
    for axes, studies, law in zip(panels, (THESIS, OURS), ("thesis's law", "ours"), strict=True):
        nearest_m = np.array(
            [[summary_of(chosen(runs, studies[slot_s, loss])).ever_m for loss in losses] for slot_s in slots]
        )
        axes.imshow(nearest_m, cmap="RdYlGn", vmin=0.0, vmax=2.0, origin="lower", aspect="auto")
        for (row, column), value in np.ndenumerate(nearest_m):
            ink = "white" if value < HULLS_TOUCH_M else "black"
            axes.text(column, row, f"{value:.2f} m", ha="center", va="center", color=ink)
        axes.grid(visible=False)
        axes.set_xticks(range(len(losses)), [f"{100.0 * loss:.0f} %" for loss in losses])
        axes.set_yticks(range(len(slots)), [f"{slot_s:g} s" for slot_s in slots])
        axes.set_xlabel("packets lost")
        axes.set_title(law)
    panels[0].set_ylabel("slot")


def _words(summaries: Sequence[Summary]) -> str:
    ever_m, formed_m = (min(getattr(s, key) for s in summaries) for key in ("ever_m", "formed_m"))
    touching, count = sum(s.n_touching for s in summaries), sum(s.n for s in summaries)
    a_cell = f" and in {share_words(0, min(s.n for s in summaries))} of a cell" if not touching else ""
    return (
        f"smallest distance over {count} runs {ever_m:.2f} m, {formed_m:.2f} m for t > 150 s; "
        f"hulls touch in {share_words(touching, count)}{a_cell}"
    )


def _judge(study: Study, bars: dict[Cell, Bars]) -> Callable[[list[Run]], Verdict]:
    def judge(runs: list[Run]) -> Verdict:
        summaries = {cell: summary_of(chosen(runs, specs)) for cell, specs in study.items()}
        kept = [cell for cell in CELLS if summaries[cell].keeps(bars[cell])]
        is_whole = all(summaries[cell].n == len(study[cell]) for cell in CELLS)
        holds = DOES_NOT_HOLD if len(kept) < len(CELLS) else HOLDS if is_whole else HOLDS_IN_PART
        return Verdict(
            holds, f"{_words(list(summaries.values()))}; limits kept in {len(kept)} of {len(CELLS)} cells"
        )

    return judge


FIGURES = (
    Figure(
        "A.41",
        "Distances of pairs, slots of 2 s, 30 % lost: the thesis's law and ours, from one start",
        _SHOWN_SLOW,
        _draw_distances,
        "No counterpart in the thesis. Black: nearest pair; grey: up to the farthest; red: hulls touch.",
    ),
    Figure(
        "A.42",
        "Smallest distance of any pair over all runs, by slot and loss",
        (*_ALL_THESIS, *_ALL_OURS),
        _draw_map,
        "No counterpart in the thesis. Hulls touch at 0.62 m.",
    ),
)

_FORM = "smallest distance, for t > 150 s, largest for t > 200 s, path error once formed (95th percentile)"
_FOUR = "the same four numbers"
TABLES = (
    Table("A.41", f"Safety of the law for a modem: {_FORM}", _ALL_OURS, _rows_of(OURS, BARS), "limits"),
    Table(
        "A.42",
        f"The thesis's law with blind followers in the same runs: {_FOUR}",
        _ALL_THESIS,
        _rows_of(THESIS, BARS),
        "limits",
    ),
    Table(
        "A.43",
        f"Navigations that drift by 1 cm/s: {_FOUR}",
        (*_ALL_SONAR, *_ALL_FIXES, *_all(list(OTHERWISE_NAVIGATED.values()))),
        _navigation_rows,
        "limits",
    ),
    Table(
        "A.44",
        f"Effect of each part of the law: {_FOUR}",
        (*_FULL, *_all(list(ABLATED.values()))),
        _part_rows,
    ),
    Table("A.45", f"Larger fleets: {_FOUR}", _all(list(FLEETS.values())), _fleet_rows),
)

CLAIMS = (
    Claim(
        "A.41",
        "The thesis's law keeps vehicles apart at the report rates and losses of a modem.",
        _ALL_THESIS,
        _judge(THESIS, BARS),
    ),
    Claim(
        "A.42",
        "A law that is no faster than its information keeps them apart, and near the path (ours).",
        _ALL_OURS,
        _judge(OURS, BARS),
    ),
    Claim(
        "A.43",
        "If navigations drift, sonar keeps the distances that exact navigation keeps (ours).",
        _ALL_SONAR,
        _judge(WITH_SONAR, SONAR_BARS),
    ),
    Claim(
        "A.44",
        "If navigations drift, one fix per minute keeps vehicles apart and the flock near its path (ours).",
        _ALL_FIXES,
        _judge(WITH_FIXES, FIXES_BARS),
    ),
)
