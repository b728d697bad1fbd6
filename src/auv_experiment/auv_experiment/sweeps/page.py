"""The page of a sweep: one self-contained HTML file; every number in it comes from the table."""

from __future__ import annotations

import html
import shlex
from collections.abc import Mapping, Sequence
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
from auv_experiment.sweeps.summary import Group, grid_groups, metric_of, n_failed
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
        "Mean and 95 % confidence interval: Student's t over runs; of shares, Wilson's score interval. "
        "A metric's statistics leave out runs that failed and runs without the metric."
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
        f"<div class='scroll'>\n{_metric_table(table, name)}\n</div></section>"
    )


def _metric_table(table: SweepTable, name: str) -> str:
    groups = grid_groups(table)
    words = ("runs", "failed", "counted", "mean", "95 % from", "to", "smallest", "median", "largest")
    cells = "".join(
        f"<th scope='col'>{html.escape(parameter_label(table, path))}</th>" for path in table.study.grid or {}
    )
    cells += "".join(f"<th scope='col' class='value'>{word}</th>" for word in words)
    rows = [f"<tr>{cells}</tr>", *(_group(table, name, group) for group in groups[:_MOST_GROUPS])]
    more = len(groups) - _MOST_GROUPS
    note = f"\n<p>{more} more points are in summary.csv.</p>" if more > 0 else ""
    return f"<table>\n{chr(10).join(rows)}\n</table>{note}"


def _group(table: SweepTable, name: str, group: Group) -> str:
    summary, digits = metric_of(table, name, group), meaning_of(name).digits
    digits = max(digits, 2)
    counts = (len(group.rows), n_failed(table, group), summary.n)
    numbers = (summary.mean, summary.low, summary.high, summary.smallest, summary.median, summary.largest)
    texts = [*(str(count) for count in counts), *(metric_text(number, digits) for number in numbers)]
    values = "".join(
        f"<td>{html.escape(value_label(table, path, value))}</td>" for path, value in group.values.items()
    )
    return f"<tr>{values}{''.join(f'<td class=value>{html.escape(text)}</td>' for text in texts)}</tr>"


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
