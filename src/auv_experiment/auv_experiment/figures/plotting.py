"""
Parts of figures: styles that can be read in grey, reduced lines, scales, legends, patches.

This module does not depend on the content of figures. Positions are in map_ned (m); plan views have east to
the right and north up.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure as Canvas
from matplotlib.patches import Circle, Patch
from matplotlib.ticker import FuncFormatter, LogLocator
from numpy.typing import NDArray

from auv_experiment.figures.formats import PAGE_FORMAT
from auv_experiment.recording import FloatArray

MAX_COLUMNS = 1200
MAX_LINES = 10
PAGE_STYLE: dict[str, Any] = {
    "figure.figsize": (6.5, 3.6),
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.labelsize": 9.0,
    "legend.fontsize": 8.0,
    "legend.framealpha": 0.9,
    "axes.grid": True,
    "grid.color": "0.88",
    "grid.linewidth": 0.5,
    "axes.axisbelow": True,
    "lines.linewidth": 1.0,
    "lines.markersize": 4.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
}
"""For pages: PNG."""
PAPER_STYLE: dict[str, Any] = {
    **PAGE_STYLE,
    "figure.figsize": (3.5, 2.4),
    "font.size": 8.0,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "legend.fontsize": 7.0,
    "lines.markersize": 3.5,
    "pdf.fonttype": 42,  # TrueType, embedded and searchable; journals refuse the Type 3 of the default
    "svg.fonttype": "path",  # letters as outlines: an SVG cannot embed the font, and a reader may lack it
    "svg.hashsalt": "shoal",
}
"""For one column of a paper: PDF and SVG."""
_WIDE_IN = 5.0
_PAPER_HEIGHT = 0.8
_HANDLE_EM, _LETTER_EM = 4.8, 0.58
"""Width of a legend's column beside its words, and of a letter (em)."""
_METADATA: dict[str, dict[str, None]] = {
    "png": {"Software": None},
    "pdf": {"Creator": None, "Producer": None, "CreationDate": None},
    "svg": {"Date": None},
}
# dark to light, distinguishable in grey and by colour-blind readers
_COLOURS = ("#111111", "#0063a8", "#c84b00", "#3a9d6e", "#7b3f8c", "#b58900")
_DASHES: tuple[Any, ...] = ("solid", (0, (5, 1.5)), (0, (6, 1.5, 1.5, 1.5)), (0, (1.5, 1.2)), (0, (9, 2)))
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")


def colour(i: int) -> str:
    """Return the colour of line i."""
    return _COLOURS[i % len(_COLOURS)]


def marker(i: int) -> str:
    """Return the marker of line i."""
    return _MARKERS[i % len(_MARKERS)]


def vehicle_style(i: int) -> dict[str, Any]:
    """Return colour and line style of line i."""
    return {"color": colour(i), "linestyle": _DASHES[i % len(_DASHES)]}


def new_canvas(height_in: float = 3.6, *, layout: Literal["constrained"] | None = "constrained") -> Canvas:
    """
    Return an empty figure with the width of the style.

    Parameters
    ----------
    height_in : float
        Height in the style of pages (in); it is smaller in that of papers.
    layout : str or None
        As of Matplotlib.

    """
    canvas = Canvas(layout=layout)
    set_height(canvas, height_in)
    return canvas


def set_height(canvas: Canvas, height_in: float) -> None:
    """Set a figure's height in the style of pages (in); it is smaller in that of papers."""
    canvas.set_figheight(height_in if _is_wide(canvas) else _PAPER_HEIGHT * height_in)


def side_by_side(canvas: Canvas, count: int, width_ratios: Sequence[float] | None = None) -> list[Any]:
    """Return axes side by side; in a narrow figure, which becomes higher, one above the other."""
    if _is_wide(canvas):
        return list(canvas.subplots(1, count, width_ratios=width_ratios, squeeze=False)[0])
    canvas.set_figheight((0.5 + 0.4 * count) * canvas.get_figheight())
    return list(canvas.subplots(count, 1, squeeze=False)[:, 0])


def space_axes(canvas: Canvas) -> Any:
    """Return axes in space, with space below for a legend."""
    place = (0.0, 0.12, 0.94, 0.88) if _is_wide(canvas) else (0.07, 0.18, 0.7, 0.8)
    return canvas.add_axes(place, projection="3d")


def wrap_words(canvas: Canvas) -> None:
    """Break titles and labels of the upright axes that are longer than their axes."""
    canvas.draw_without_rendering()  # lays the axes out
    for axes in canvas.axes:
        box = axes.get_window_extent()
        for text, length in ((axes.title, box.width), (axes.yaxis.label, box.height)):
            letters = length / (_LETTER_EM * float(text.get_fontsize()) * canvas.dpi / 72.0)
            if len(text.get_text()) > letters:
                text.set_text(textwrap.fill(text.get_text(), max(int(letters), 8), break_long_words=False))


def _is_wide(canvas: Canvas) -> bool:
    return canvas.get_figwidth() > _WIDE_IN


def style_of(file_format: str) -> dict[str, Any]:
    """Return the style in which figures of a format are drawn and saved."""
    return PAGE_STYLE if file_format == PAGE_FORMAT else PAPER_STYLE


def save_canvas(canvas: Canvas, target: Path | BytesIO, file_format: str, *, dpi: int) -> None:
    """Write a figure, the same bytes whenever it is drawn; in the style of its format."""
    canvas.savefig(target, dpi=dpi, format=file_format, metadata=_METADATA[file_format])


def plot_plan_line(axes: Any, ned_m: FloatArray, **style: Any) -> None:
    """Plot an (n, 3) track as seen from above."""
    axes.plot(ned_m[:, 1], ned_m[:, 0], **style)


def mark(axes: Any, ned_m: FloatArray, i: int, *, is_filled: bool) -> None:
    """Mark one position of vehicle i, seen from above, hollow or full."""
    fill = colour(i) if is_filled else "white"
    axes.plot(ned_m[1], ned_m[0], marker(i), color=colour(i), markerfacecolor=fill, markersize=6, zorder=6)


def plot_obstacle(axes: Any, obstacle: Any) -> None:
    """Plot an obstacle and its safety distance, seen from above."""
    north, east, _ = obstacle.position_ned_m
    axes.add_patch(
        Circle(
            (east, north),
            obstacle.safety_distance_m,
            facecolor="0.94",
            edgecolor="0.45",
            linestyle="dashed",
            zorder=0,
        )
    )
    axes.plot(east, north, "x", color="black", markersize=7, markeredgewidth=1.8, zorder=6)


def plot_sphere(axes: Any, centre_ned_m: Any, radius_m: float) -> None:
    """Plot a translucent sphere into axes in space."""
    azimuth, polar = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 25), np.linspace(0.0, np.pi, 13))
    north, east, down = centre_ned_m
    axes.plot_surface(
        east + radius_m * np.sin(polar) * np.cos(azimuth),
        north + radius_m * np.sin(polar) * np.sin(azimuth),
        down + radius_m * np.cos(polar),
        color="0.75",
        alpha=0.35,
        linewidth=0,
    )


def equal_box(axes: Any) -> None:
    """Give axes in space one scale on all axes."""
    limits = np.array([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()])
    axes.set_box_aspect(np.maximum(np.ptp(limits, axis=1), 1e-6), zoom=1.06)


def round_ticks(t_s: FloatArray) -> list[int]:
    """Return the ticks of about six round times after the start."""
    step_s = round_step(float(t_s[-1]) / 6.0)
    times_s = np.arange(step_s, t_s[-1] + 1e-9, step_s)
    ticks: list[int] = np.unique(np.clip(np.searchsorted(t_s, times_s - 1e-9), 0, len(t_s) - 1)).tolist()
    return ticks


def round_step(value: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not above the value."""
    if value <= 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return power * max((m for m in (1.0, 2.0, 5.0) if m * power <= value), default=1.0)


def span_time(axes: Any, t_s: FloatArray) -> None:
    """Set the limits of the time axis to those of the data."""
    if len(t_s) and t_s[-1] > t_s[0]:
        axes.set_xlim(t_s[0], t_s[-1])


def plot_thinned(
    axes: Any, t_s: FloatArray, values: FloatArray, *, n_marks: int = 0, first_mark: float = 0.0, **style: Any
) -> None:
    """Plot a line with n_marks markers; first_mark (0..1) staggers those of several lines."""
    shown = thin_indices(values)
    if n_marks:
        every = max(1, len(shown) // n_marks)
        style = {**style, "markevery": (int(first_mark * every), every), "markersize": 3.8}
    axes.plot(t_s[shown], values[shown], **style)


def thin_indices(values: FloatArray, n_columns: int = MAX_COLUMNS) -> NDArray[np.int64]:
    """
    Choose the samples that a plot of n_columns pixels can show.

    Parameters
    ----------
    values : (n,) array
        Samples at even steps; NaN is a gap.
    n_columns : int
        Width of the plot (pixels).

    Returns
    -------
    indices : (m,) array of int
        Ascending, m <= 2 n_columns + 2: first and last sample, the smallest and the largest of every
        column; all samples if there are few.

    """
    n = len(values)
    if n <= 2 * n_columns:
        return np.arange(n)
    edges = np.linspace(0, n, n_columns + 1).astype(np.int64)
    size = int(np.diff(edges).max())
    index = np.minimum(edges[:-1, np.newaxis] + np.arange(size), edges[1:, np.newaxis] - 1)
    columns = values[index]
    exists = np.isfinite(columns)
    lowest = np.where(exists, columns, np.inf).argmin(axis=1)
    highest = np.where(exists, columns, -np.inf).argmax(axis=1)
    rows = np.arange(n_columns)
    return np.unique(np.concatenate([[0, n - 1], index[rows, lowest], index[rows, highest]]))


def log_scale(axes: Any, values: FloatArray) -> None:
    """Scale y logarithmically with plain numbers, three decades or as many as 98 % of the data need."""
    positive = values[np.isfinite(values) & (values > 0.0)]
    if not positive.size:
        return
    high = float(positive.max())
    floor = min(float(np.quantile(positive, 0.02)), 1e-3 * high)
    low = max(float(positive.min()), floor, 1e-9 * high)
    axes.set_yscale("log")
    axes.set_ylim(0.8 * low, 1.25 * high)
    is_short = high < 300.0 * low
    axes.yaxis.set_minor_locator(
        LogLocator(subs=(2.0, 5.0) if is_short else (2.0, 4.0, 6.0, 8.0), numticks=50)
    )
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(FuncFormatter(lambda value, _: f"{value:g}" if is_short else ""))


def plot_band(axes: Any, t_s: FloatArray, two_sigma_m: FloatArray) -> None:
    """Plot the band between minus and plus two_sigma_m."""
    shown = thin_indices(two_sigma_m)
    band = two_sigma_m[shown]
    axes.fill_between(t_s[shown], -band, band, facecolor="0.78", linewidth=0.0)


def band_handle() -> Any:
    """Return the patch for forbidden distances in a legend."""
    return Patch(facecolor="0.8", hatch="////", edgecolor="0.6", linewidth=0.0)


def two_sigma_handle() -> Any:
    """Return the patch for the band of two standard deviations in a legend."""
    return Patch(facecolor="0.78", linewidth=0.0)


def legend_below(
    canvas: Canvas, handles: list[Any], labels: list[str] | None = None, *, columns: int = 4, title: str = ""
) -> None:
    """Put a legend below all axes, in columns that fit; labels default to those of the handles."""
    if not handles:
        return
    names = labels if labels is not None else [str(handle.get_label()) for handle in handles]
    width_em = 72.0 * canvas.get_figwidth() / rcParams["legend.fontsize"]
    columns = _columns_that_fit(names, columns, width_em)
    is_free = canvas.get_layout_engine() is None
    place = "lower center" if is_free else "outside lower center"
    canvas.legend(handles, names, loc=place, ncols=columns, title=title or None)


def _columns_that_fit(names: Sequence[str], most: int, width_em: float) -> int:
    """Return the number of columns, `most` or fewer, in which a legend is not wider than `width_em`."""
    for columns in range(min(most, len(names)), 1, -1):
        longest = [max(map(len, column)) for column in np.array_split(names, columns)]
        if sum(_HANDLE_EM + _LETTER_EM * length for length in longest) <= width_em:
            return columns
    return 1
