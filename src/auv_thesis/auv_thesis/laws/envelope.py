"""
Safety envelope of the law for a modem: how often hulls touch and flocks part, by fleet, cycle and burst.

The first claim begins with what is not safe. Shares have exact 95 % bounds (Clopper and Pearson), which take
runs as independent. The cells share their seeds, so a share over all cells is given for both cases: as many
independent runs, or as many as there are seeds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.confidence.binomial import share_words
from auv_thesis.acoustics.safety_runs import FAR_M, HULLS_TOUCH_M, chosen
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
from auv_thesis.laws.envelope_runs import (
    APART_SHARE,
    BURSTS_S,
    CELLS,
    FLEETS,
    N_SEEDS,
    NEAR_M,
    SAFE_SHARE,
    SLOTS_S,
    STUDY,
    Cell,
    Summary,
    seed_of,
    summary_of,
)

COMMAND = f"./scripts/reproduce --only envelope --seeds {N_SEEDS}"
Summaries = Mapping[Cell, Summary]
_ALL: tuple[RunSpec, ...] = tuple(spec for specs in STUDY.values() for spec in specs)


def summaries_of(runs: Sequence[Run]) -> dict[Cell, Summary]:
    """Return the summaries of the cells that were flown, in the order of `CELLS`."""
    return {cell: summary_of(cell, flown) for cell, flown in _by_cell(runs).items()}


def contact_words(summaries: Summaries) -> str:
    """Return the sentence on contacts: first the cells with contact, then those with too few runs to tell."""
    touching = {cell: s for cell, s in summaries.items() if s.n_touching}
    unknown = {cell: s for cell, s in summaries.items() if not s.n_touching and s.touch_bound > SAFE_SHARE}
    sentences = []
    if touching:
        sentences.append(f"Not safe: hulls touch with {_listed(touching, 'n_touching')}.")
    if unknown:
        sentences.append(
            f"Not shown to be safe, since a share of {100.0 * SAFE_SHARE:.0f} % is not excluded: contact "
            f"with {_listed(unknown, 'n_touching')}."
        )
    if not sentences:
        sentences.append("Hulls touch in no run.")
    return " ".join([*sentences, *_coverage(summaries)])


def together_words(summaries: Summaries) -> str:
    """Return the sentence on limits: cells nearer than 1 m, then cells that come apart too often."""
    near = {cell: s for cell, s in summaries.items() if s.n_near}
    apart = {cell: s for cell, s in summaries.items() if s.n_apart > APART_SHARE * s.n + 1e-9}
    sentences = []
    if near:
        sentences.append(f"Nearer than {NEAR_M:g} m with {_listed(near, 'n_near')}.")
    if apart:
        sentences.append(f"Apart with {_listed(apart, 'n_apart')}.")
    if not sentences:
        sentences.append(
            f"No run comes nearer than {NEAR_M:g} m, and no cell is apart in over "
            f"{100.0 * APART_SHARE:.0f} % of its runs."
        )
    return " ".join([*sentences, *_coverage(summaries)])


def pooled_words(runs: Sequence[Run]) -> str:
    """Return the share of contacts over all cells, if cells are independent and if their seeds decide."""
    touching = [run for run in runs if run.metrics["pair_distance_min_m"] < HULLS_TOUCH_M]
    flown = [{seed_of(run) for run in of_cell} for of_cell in _by_cell(runs).values()]
    shared = set.intersection(*flown)
    hit = {seed_of(run) for run in touching} & shared
    return (
        f"Contact over all cells: in runs {share_words(len(touching), len(runs))}, if cells are independent; "
        f"in seeds, which all cells share, {share_words(len(hit), len(shared))}, if these decide."
    )


def _by_cell(runs: Sequence[Run]) -> dict[Cell, list[Run]]:
    found = {cell: chosen(runs, specs) for cell, specs in STUDY.items()}
    return {cell: flown for cell, flown in found.items() if flown}


def _listed(summaries: Summaries, count: str) -> str:
    return "; ".join(f"{cell}: {share_words(getattr(s, count), s.n)}" for cell, s in summaries.items())


def _coverage(summaries: Summaries) -> list[str]:
    """Return what was not flown, and the command that flies all."""
    missing = len(CELLS) - len(summaries)
    is_whole = not missing and all(s.n == len(STUDY[cell]) for cell, s in summaries.items())
    if is_whole:
        return []
    n_flown, n_all = sum(s.n for s in summaries.values()), len(_ALL)
    cells = f", and {missing} of {len(CELLS)} cells not at all" if missing else ""
    return [f"These are few: {n_flown} of {n_all} runs are flown{cells}; `{COMMAND}` flies all."]


def _row(cell: Cell, summary: Summary | None) -> Row:
    if summary is None:
        return Row(str(cell), "0", "not flown", NO_NUMBER, f"`{COMMAND}` flies it")
    kept = AGREES if summary.touch_bound <= SAFE_SHARE else AGREES_IN_PART
    return Row(str(cell), str(summary.n), str(summary), kept if summary.is_kept else DIFFERS, summary.shares)


def _rows(runs: list[Run]) -> list[Row]:
    summaries = summaries_of(runs)
    return [_row(cell, summaries.get(cell)) for cell in CELLS]


def _judge_contacts(runs: list[Run]) -> Verdict:
    summaries = summaries_of(runs)
    safe = all(s.touch_bound <= SAFE_SHARE for s in summaries.values())
    is_proved = safe and len(summaries) == len(CELLS)
    any_touch = any(s.n_touching for s in summaries.values())
    holds = DOES_NOT_HOLD if any_touch else HOLDS if is_proved else HOLDS_IN_PART
    return Verdict(holds, f"{contact_words(summaries)} {pooled_words(runs)}")


def _judge_together(runs: list[Run]) -> Verdict:
    summaries = summaries_of(runs)
    is_kept = all(s.is_kept for s in summaries.values())
    is_whole = len(summaries) == len(CELLS) and all(s.n == len(STUDY[c]) for c, s in summaries.items())
    holds = DOES_NOT_HOLD if not is_kept else HOLDS if is_whole else HOLDS_IN_PART
    return Verdict(holds, together_words(summaries))


def _draw(canvas: Canvas, runs: list[Run]) -> None:
    summaries = summaries_of(runs)
    panels = canvas.subplots(1, 1 + len(BURSTS_S), sharey=True)
    for axes, burst_s in zip(panels, (None, *BURSTS_S), strict=True):
        shown = {
            (SLOTS_S.index(cell.slot_s), FLEETS.index(cell.n_vehicles)): summaries.get(cell)
            for cell in CELLS
            if replace(cell, runs_per_seed=1) == Cell(cell.n_vehicles, cell.slot_s, burst_s)
        }
        nearest_m = np.full((len(SLOTS_S), len(FLEETS)), np.nan)
        for place, summary in shown.items():
            words = "not\nflown"
            if summary is not None:
                nearest_m[place] = summary.nearest_m
                words = f"{summary.nearest_m:.2f} m\n{summary.n_touching} / {summary.n_apart}\nof {summary.n}"
            axes.text(place[1], place[0], words, ha="center", va="center", fontsize="small")
        axes.imshow(nearest_m, cmap="RdYlGn", vmin=0.0, vmax=2.0, origin="lower", aspect="auto")
        axes.grid(visible=False)
        axes.set_xticks(range(len(FLEETS)), [str(n) for n in FLEETS])
        axes.set_yticks(range(len(SLOTS_S)), [f"{slot_s:g} s" for slot_s in SLOTS_S])
        axes.set_title("30 % lost" if burst_s is None else f"bursts of {burst_s:g} s")
        axes.set_xlabel("vehicles")
    panels[0].set_ylabel("slot")


CLAIMS = (
    Claim(
        "E.1", "The law for a modem keeps hulls apart in the whole envelope (ours).", _ALL, _judge_contacts
    ),
    Claim(
        "E.2",
        f"It keeps {NEAR_M:g} m between vehicles, and the flock together, in the whole envelope (ours).",
        _ALL,
        _judge_together,
    ),
)
TABLES = (
    Table(
        "E.1",
        "Safety envelope: smallest distance of all runs, and its 5th percentile. Limits: no contact, "
        f"{NEAR_M:g} m, over {FAR_M:g} m in at most {100.0 * APART_SHARE:.0f} %",
        _ALL,
        _rows,
        "runs",
    ),
)
FIGURES = (
    Figure(
        "E.1",
        "Safety envelope: smallest distance, runs with contact / runs apart",
        _ALL,
        _draw,
        "No counterpart in the thesis. Hulls touch at 0.62 m. Bursts: means as wanted, see the table.",
    ),
)
