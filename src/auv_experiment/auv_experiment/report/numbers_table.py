"""The table of a run's metrics, with reference values if there are any."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any

from auv_experiment.metrics.wording import shown_metrics, value_text

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

# Continuous-time solution of the same equations (RK4, 0.01 s, 650 s) and, where printed, the thesis's value.
_REFERENCES: dict[str, dict[str, tuple[float, str]]] = {
    "ch5_four_leaders": {
        "pair_distance_settled_min_m": (1.5950, "1.575"),
        "pair_distance_settled_max_m": (1.5950, "1.616"),
        "pair_distance_min_m": (1.451, ""),
        "approach_time_2pct_s": (3.90, "2.9 (other starts)"),
        "centroid_path_rms_m": (0.1000, ""),
        "consensus_error_max_m": (0.2895, ""),
    },
    "ch5_one_leader": {
        "pair_distance_settled_min_m": (1.5908, "1.584"),
        "pair_distance_settled_max_m": (1.6078, "1.611"),
        "pair_distance_min_m": (1.449, ""),
        "approach_time_2pct_s": (4.00, "2.4 (other starts)"),
        "centroid_path_rms_m": (0.1749, ""),
        "consensus_error_max_m": (0.2680, ""),
    },
    "ch5_one_leader_blind": {
        "pair_distance_settled_min_m": (1.7171, ""),
        "pair_distance_settled_max_m": (1.8844, ""),
        "pair_distance_min_m": (1.605, ""),
        "approach_time_2pct_s": (56.4, ""),
        "centroid_path_rms_m": (1.8759, ""),
        "consensus_error_max_m": (0.2697, ""),
    },
    "ch5_obstacles": {
        "obstacle_clearance_min_m": (1.298, ""),
        "centroid_path_rms_m": (0.243, ""),
    },
}


def numbers_table(scenario: Scenario, metrics: dict[str, Any]) -> str:
    """Return the table of the metrics that have a value, with two more columns if there are references."""
    references = _REFERENCES.get(scenario.name, {})
    head = "<tr><th>meaning</th><th class='value'>value</th><th>unit</th>"
    head += "<th class='value'>reference</th><th class='value'>thesis</th>" if references else ""
    rows = [head + "<th class='key'>key</th></tr>"]
    for key, meaning in shown_metrics(metrics):
        if metrics[key] is None:
            continue
        text = value_text(metrics[key], meaning.digits)
        cells = [f"<td>{html.escape(meaning.words)}</td>"]
        kind = "words" if isinstance(metrics[key], str | list) else "value"
        cells.append(f"<td class='{kind}'>{html.escape(text)}</td>")
        cells.append(f"<td>{html.escape(meaning.unit)}</td>")
        if references:
            reference, thesis = references.get(key, (None, ""))
            shown = "" if reference is None else f"{reference:g}"
            cells.append(f"<td class='value'>{shown}</td><td class='value'>{html.escape(thesis)}</td>")
        cells.append(f"<td class='key'><code>{html.escape(key)}</code></td>")
        rows.append(f"<tr>{''.join(cells)}</tr>")
    note = (
        "<p>Reference: the same equations in continuous time (Runge-Kutta, 0.01 s, 650 s). "
        "Thesis: the number printed there.</p>"
        if references
        else ""
    )
    return "<table>\n" + "\n".join(rows) + "\n</table>\n" + note
