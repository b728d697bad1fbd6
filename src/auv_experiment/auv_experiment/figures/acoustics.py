"""
Figures of the outcomes of packets: delivery by link, losses by cause, delays.

Links are ordered pairs, the sender first. Causes of loss differ in grey and in hatching, so that they can be
distinguished without colour.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from auv_core.messages import Outcome
from auv_experiment.confidence.binomial import wilson_interval
from auv_experiment.figures import Drawer, Drawing
from auv_experiment.figures.estimates import ESTIMATE_DRAWERS
from auv_experiment.figures.plotting import legend_below, new_canvas, side_by_side
from auv_experiment.metrics import acoustics as metrics_acoustics
from auv_experiment.metrics.links import link_counts
from auv_experiment.recording import IntArray, Recording

if TYPE_CHECKING:
    pass

MAX_LABELLED_LINKS = 30
_DELAY_BINS = 40
_SAME_S = 1e-6
_CAUSES: dict[Outcome, tuple[str, dict[str, Any]]] = {
    Outcome.OUTAGE: ("outage", {"facecolor": "0.88"}),
    Outcome.NOISE: ("noise", {"facecolor": "0.68", "hatch": "////"}),
    Outcome.COLLISION: ("collision", {"facecolor": "0.40"}),
    Outcome.HALF_DUPLEX: ("receiver was transmitting", {"facecolor": "white", "hatch": "xxxx"}),
    Outcome.RANGE: ("out of range", {"facecolor": "0.08"}),
}


def acoustics_drawers(recording: Recording, *, only: Collection[str] | None = None) -> dict[str, Drawer]:
    """Return the drawing functions of network, navigation and neighbour filters, by name."""
    return {
        name: partial(draw, recording)
        for name, draw in (_DRAWERS | ESTIMATE_DRAWERS).items()
        if only is None or name in only
    }


def _draw_packet_losses(recording: Recording) -> Drawing | None:
    counts = metrics_acoustics.loss_counts(recording)
    total: IntArray = np.sum(list(counts.values()), axis=0)
    lost = total - counts[Outcome.DELIVERED]
    if not metrics_acoustics.has_modem(recording) or not lost.any():
        return None
    links = [(i, j) for i, j in np.argwhere(total > 0).tolist()]
    panels = _loss_rows(recording, links, counts, total)
    height_in = 1.3 + 0.19 * max(len(names) for _, names, _ in panels)
    canvas = new_canvas(height_in)
    for axes, (title, names, ratios) in zip(side_by_side(canvas, len(panels)), panels, strict=True):
        _plot_stacked(axes, names, ratios)
        axes.set_title(title)
        axes.set_xlabel("share of packets lost")
    shown = [outcome for outcome in _CAUSES if counts[outcome].any()]
    legend_below(canvas, [_cause_handle(outcome) for outcome in shown])
    parts = ", ".join(f"{_CAUSES[outcome][0]} {counts[outcome].sum() / total.sum():.1%}" for outcome in shown)
    caption = (
        f"Of {total.sum()} packets at their receivers {lost.sum()} were lost: {parts}. Each lost packet has "
        "one cause, the first one; outage means losses that no model of noise explains."
    )
    return Drawing(canvas, "Losses by cause", caption)


def _loss_rows(
    recording: Recording,
    links: list[tuple[int, int]],
    counts: dict[Outcome, IntArray],
    total: IntArray,
) -> list[tuple[str, list[str], dict[Outcome, NDArray[np.float64]]]]:
    """
    Return panels of (title, names of rows, share lost by cause): links, or vehicles if there are too many
    links.
    """
    ids = recording.vehicle_ids
    if len(links) <= MAX_LABELLED_LINKS:
        i, j = np.transpose(links)
        ratios = {outcome: counts[outcome][i, j] / total[i, j] for outcome in _CAUSES}
        return [("by link", [f"{ids[a]} → {ids[b]}" for a, b in links], ratios)]
    panels = []
    for title, axis in (("by sender", 1), ("by receiver", 0)):
        whole = np.maximum(total.sum(axis=axis), 1)
        panels.append((title, list(ids), {o: counts[o].sum(axis=axis) / whole for o in _CAUSES}))
    return panels


def _plot_stacked(axes: Any, names: list[str], ratios: dict[Outcome, NDArray[np.float64]]) -> None:
    rows = np.arange(len(names))
    left = np.zeros(len(names))
    for outcome, (_, style) in _CAUSES.items():
        axes.barh(rows, ratios[outcome], left=left, height=0.72, edgecolor="0.2", linewidth=0.5, **style)
        left = left + ratios[outcome]
    axes.set_yticks(rows, names, fontsize=7)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xlim(0.0, min(1.0, 1.06 * float(left.max())))
    axes.grid(visible=False, axis="y")


def _cause_handle(outcome: Outcome) -> Patch:
    words, style = _CAUSES[outcome]
    return Patch(edgecolor="0.2", linewidth=0.5, label=words, **style)


def _draw_packet_delay(recording: Recording) -> Drawing | None:
    delay_s = recording.delay_s[np.isfinite(recording.delay_s)]
    if not metrics_acoustics.has_modem(recording) or not len(delay_s) or np.ptp(delay_s) < _SAME_S:
        return None
    is_wide = delay_s.min() > 0.0 and delay_s.max() > 30.0 * delay_s.min()
    canvas = new_canvas(2.8)
    axes = canvas.add_subplot()
    low_s, high_s = float(delay_s.min()), float(delay_s.max())
    space = np.geomspace if is_wide else np.linspace
    edges_s: list[float] = space(low_s, high_s, _DELAY_BINS + 1).tolist()
    axes.hist(delay_s, edges_s, facecolor="0.75", edgecolor="0.3", linewidth=0.5)
    mean_s, late_s = float(delay_s.mean()), float(np.quantile(delay_s, 0.95))
    axes.axvline(mean_s, color="black", linewidth=1.2, label=f"mean {mean_s:.3f} s")
    axes.axvline(late_s, color="black", linewidth=1.2, linestyle="dashed", label=f"95 % below {late_s:.3f} s")
    if is_wide:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlabel("delay (s)")
    axes.set_ylabel("packets received")
    legend_below(canvas, *axes.get_legend_handles_labels())
    caption = (
        f"Delay of {len(delay_s)} packets, from the start of a transmission to the end of its reception: "
        f"airtime and travel, {low_s:.3f} to {high_s:.3f} s. It does not include the wait for medium access."
    )
    return Drawing(canvas, "Delay of packets", caption)


def _draw_packet_delivery(recording: Recording) -> Drawing | None:
    expected, delivered = link_counts(recording)
    if expected.sum() == 0:
        return None
    overall = delivered.sum() / expected.sum()
    links = [(i, j) for i, j in np.argwhere(expected > 0).tolist()]
    is_few = len(links) <= MAX_LABELLED_LINKS
    canvas = new_canvas(3.5 if len(links) <= 12 else 5.5)
    axes = side_by_side(canvas, 2 if is_few else 1, (4, 5) if is_few else None)
    _plot_delivery_matrix(axes[0], recording, expected, delivered, has_numbers=is_few)
    if is_few:
        _plot_delivery_bands(axes[1], recording, links, expected, delivered, overall)
    caption = (
        "Share of packets that arrived, link by link (row sends, column receives; darker means more "
        f"losses): {overall:.3f} of {expected.sum()} in total."
    )
    if is_few:
        caption += (
            " Right, the same with the 95 % confidence interval for this number of independent trials "
            "(Wilson); an interval that does not include the mean suggests a link unlike the others."
        )
    return Drawing(canvas, "Packet delivery by link", caption)


def _plot_delivery_matrix(
    axes: Any,
    recording: Recording,
    expected: IntArray,
    delivered: IntArray,
    *,
    has_numbers: bool,
) -> None:
    ratio = np.where(expected > 0, delivered / np.maximum(expected, 1), np.nan)
    image = axes.imshow(1.0 - ratio, cmap="Greys", vmin=0.0, vmax=1.0)
    axes.grid(visible=False)
    ids = recording.vehicle_ids
    if len(ids) <= 16:
        axes.set_xticks(range(len(ids)), ids, rotation=45, ha="right", rotation_mode="anchor")
        axes.set_yticks(range(len(ids)), ids)
    axes.set_xlabel("receiver")
    axes.set_ylabel("sender")
    if not has_numbers:
        axes.figure.colorbar(image, ax=axes, label="share lost")
        return
    for i, j in np.argwhere(expected > 0).tolist():
        colour = "white" if ratio[i, j] < 0.45 else "black"
        text = f"{ratio[i, j]:.2f}\n{delivered[i, j]}/{expected[i, j]}"
        axes.text(j, i, text, ha="center", va="center", color=colour, fontsize=7)


def _plot_delivery_bands(
    axes: Any,
    recording: Recording,
    links: list[tuple[int, int]],
    expected: IntArray,
    delivered: IntArray,
    overall: float,
) -> None:
    rows = np.arange(len(links))
    counts = np.array([(delivered[link], expected[link]) for link in links])
    ratio = counts[:, 0] / counts[:, 1]
    low, high = wilson_interval(counts[:, 0], counts[:, 1])
    widths = (np.maximum(ratio - low, 0.0), np.maximum(high - ratio, 0.0))
    axes.errorbar(ratio, rows, xerr=widths, fmt="o", color="black", capsize=2.5, linewidth=0.9)
    axes.axvline(overall, color="0.35", linewidth=1.0, linestyle="dashed")
    axes.annotate(
        f"all links {overall:.3f}", (overall, -0.6), xytext=(4, 0), textcoords="offset points", fontsize=8
    )
    ids = recording.vehicle_ids
    axes.set_yticks(rows, [f"{ids[i]} → {ids[j]}" for i, j in links], fontsize=7)
    axes.set_ylim(len(links) - 0.4, -1.0)
    axes.set_xlabel("delivery ratio, 95 % interval")


_DRAWERS: dict[str, Callable[[Recording], Drawing | None]] = {
    "packet_delivery": _draw_packet_delivery,
    "packet_losses": _draw_packet_losses,
    "packet_delay": _draw_packet_delay,
}
