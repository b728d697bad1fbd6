"""The page of a sweep: one self-contained HTML file; every number in it comes from the table."""

from __future__ import annotations

import html
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from auv_core.machine.whole_files import write_text
from auv_core.params import dump
from auv_experiment.metrics.wording import meaning_of
from auv_experiment.metrics.wording import value_text as metric_text
from auv_experiment.report.html import embedded_png, head, pairs_table
from auv_experiment.scenario.strict_yaml import to_yaml
from auv_experiment.sweeps.figures import axis_parameter, line_parameters
from auv_experiment.sweeps.labels import parameter_label, value_label
from auv_experiment.sweeps.plan import override_texts
from auv_experiment.sweeps.statistics import Difference, Summary
from auv_experiment.sweeps.summary import (
    Group,
    difference_of,
    grid_groups,
    metric_of,
    n_failed,
    neighbouring_groups,
)
from auv_experiment.sweeps.table import DONE, SweepTable

PAGE_FILE = "index.html"
_MOST_FAILURES = 50
_MOST_GROUPS = 100


def write_page(folder: Path, table: SweepTable, metrics: Sequence[str], figures: Mapping[str, Path]) -> Path:
    """
    Write the page.

    Parameters
    ----------
    folder : Path
        Folder of the sweep.
    table : SweepTable
        All of its runs.
    metrics : sequence of str
        The metrics to show, in this order.
    figures : mapping of str to Path
        PNG files by metric.

    """
    study = table.study
    sections = "\n".join(_metric(table, name, figures.get(name)) for name in metrics)
    path = folder / PAGE_FILE
    title = html.escape(study.title)
    write_text(
        path,
        f"{head(study.title)}\n<body>\n<header><h1>{title}</h1>\n"
        f"<p class='facts'>{_facts(table)}</p></header>\n<main>\n{_failures(table)}\n{_how_to_read(table)}\n"
        f"{sections}\n{_making(table)}\n</main>\n</body>\n</html>\n",
    )
    return path


def failed_rows(table: SweepTable) -> list[int]:
    """Return the rows of the runs that failed."""
    return [row for row, status in enumerate(table.columns["status"]) if status != DONE]


def command_of(table: SweepTable, row: int) -> str:
    """Return the command that flies the run of a row alone."""
    words = ["./scripts/run", table.study.scenario, "--seed", str(table.columns["seed"][row])]
    for text in override_texts(table.study, table.parameters(row)):
        words += ["--set", text]
    return shlex.join([*words, "--mode", "inprocess"])


def _facts(table: SweepTable) -> str:
    cpu_s = sum(time_s or 0.0 for time_s in table.columns["cpu_s"])
    n_failed_runs = len(failed_rows(table))
    failed = f", {n_failed_runs} of them failed" if n_failed_runs else ""
    return (
        f"{table.n_runs} runs of <code>{html.escape(table.study.scenario)}</code>{failed}; "
        f"{len(table.study.seeds)} seeds at each point; {cpu_s:.0f} s of processor time"
    )


def _how_to_read(table: SweepTable) -> str:
    x, lines = axis_parameter(table), line_parameters(table)
    pooled = [path for path in table.study.parameters if path != x and path not in lines]
    words = (
        "Intervals are 95 % confidence intervals; the last column names the method and what counts as "
        "independent. Runs with one seed, or with one draw of the sampled parameters, are one cluster. "
        "A metric's statistics leave out runs that failed and runs without the metric."
    )
    if table.study.grid:
        words += (
            " Differences are between runs with the same seed and draw; their intervals follow from them."
        )
    if pooled:
        words += f" Figures pool the runs over {', '.join(parameter_label(table, path) for path in pooled)}."
    return f"<p>{html.escape(words)}</p>"


def _metric(table: SweepTable, name: str, figure: Path | None) -> str:
    meaning = meaning_of(name)
    words = meaning.words + (f" ({meaning.unit})" if meaning.unit else "")
    image = "<p>No run has this metric.</p>"
    if figure is not None:
        image = f"<figure>\n{embedded_png(figure.read_bytes(), words)}\n</figure>"
    heading = html.escape(words[:1].upper() + words[1:])
    return (
        f"<section><h2>{heading}</h2>\n<p><code>{html.escape(name)}</code></p>\n{image}\n"
        f"<div class='scroll'>\n{_metric_table(table, name)}\n</div>{_differences(table, name)}</section>"
    )


def _metric_table(table: SweepTable, name: str) -> str:
    words = ("runs", "failed", "counted", "mean", "95 % from", "to", "smallest", "median", "95 % from", "to")
    rows = [
        ([*_labels(table, group)], [*_numbers(table, name, group)], _method(metric_of(table, name, group)))
        for group in grid_groups(table)[:_MOST_GROUPS]
    ]
    more = len(grid_groups(table)) - _MOST_GROUPS
    note = f"\n<p>{more} more points are in summary.csv.</p>" if more > 0 else ""
    return _table(_parameters(table), (*words, "largest"), rows) + note


def _numbers(table: SweepTable, name: str, group: Group) -> Iterator[str]:
    summary = metric_of(table, name, group)
    yield from map(str, (len(group.rows), n_failed(table, group), summary.n))
    around_mean = (summary.mean, summary.low, summary.high)
    around_median = (summary.median, summary.median_low, summary.median_high)
    for number in (*around_mean, summary.smallest, *around_median, summary.largest):
        yield metric_text(number, _digits(name))


def _differences(table: SweepTable, name: str) -> str:
    """Return the paired differences between points that differ in one parameter, '' if there are none."""
    neighbours = neighbouring_groups(table)
    rows = []
    for path, group, base in neighbours[:_MOST_GROUPS]:
        found = difference_of(table, name, group, base)
        numbers = (metric_text(number, _digits(name)) for number in (found.difference, found.low, found.high))
        labels = [
            *_labels(table, group),
            f"{parameter_label(table, path)} {value_label(table, path, base.values[path])}",
        ]
        rows.append((labels, [str(found.pairs), *numbers], _method(found)))
    if not rows:
        return ""
    more = len(neighbours) - _MOST_GROUPS
    note = f"\n<p>{more} more are in differences.csv.</p>" if more > 0 else ""
    heads = ("pairs", "difference", "95 % from", "to")
    cells = _table([*_parameters(table), "less that with"], heads, rows)
    return (
        "\n<details><summary>Paired differences from the first value of a parameter</summary>\n"
        f"<div class='scroll'>\n{cells}{note}\n</div></details>"
    )


def _table(
    labels: Sequence[str], numbers: Sequence[str], rows: Sequence[tuple[Sequence[str], Sequence[str], str]]
) -> str:
    """Return a table: labels and numbers under their headings, and the method of the interval."""
    head = "".join(f"<th scope='col'>{html.escape(label)}</th>" for label in labels)
    head += "".join(f"<th scope='col' class='value'>{number}</th>" for number in numbers)
    lines = [f"<tr>{head}<th scope='col'>interval</th></tr>"]
    for texts, values, method in rows:
        cells = "".join(f"<td>{html.escape(text)}</td>" for text in texts)
        cells += "".join(f"<td class=value>{html.escape(value)}</td>" for value in values)
        lines.append(f"<tr>{cells}<td>{html.escape(method)}</td></tr>")
    return f"<table>\n{chr(10).join(lines)}\n</table>"


def _parameters(table: SweepTable) -> list[str]:
    return [parameter_label(table, path) for path in table.study.grid or {}]


def _labels(table: SweepTable, group: Group) -> list[str]:
    return [value_label(table, path, value) for path, value in group.values.items()]


def _method(found: Summary | Difference) -> str:
    return f"{found.method}, {found.clusters}" if found.method else "–"


def _digits(name: str) -> int:
    return max(meaning_of(name).digits, 2)


def _failures(table: SweepTable) -> str:
    rows = failed_rows(table)
    if not rows:
        return ""
    items = "\n".join(
        f"<li><code>{html.escape(command_of(table, row))}</code><br>"
        f"{html.escape(table.columns['error'][row])}</li>"
        for row in rows[:_MOST_FAILURES]
    )
    more = f"<p>The first {_MOST_FAILURES} of {len(rows)}.</p>" if len(rows) > _MOST_FAILURES else ""
    return f"<section class='failure'><h2>Runs that failed</h2><ul>\n{items}\n</ul>{more}</section>"


def _making(table: SweepTable) -> str:
    study = html.escape(to_yaml(dump(table.study)))
    return (
        f"<section><h2>How it was made</h2>\n<div class='scroll'>\n{pairs_table(table.making)}\n</div>\n"
        f"<details><summary>The study</summary><pre>{study}</pre></details></section>"
    )
