"""Figures of the network, the filters and the navigation: drawn where data exist, skipped where not."""

from __future__ import annotations

import struct
from collections.abc import Collection
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from auv_core.messages import Outcome
from auv_experiment.figures import Figure
from auv_experiment.figures.acoustics import acoustics_drawers
from auv_experiment.figures.by_law import run_drawers
from auv_experiment.figures.files import save_figures
from auv_experiment.recording import Recording

OF_ESTIMATES = ["packet_delivery", "estimate_error"]
ALL = [
    "packet_delivery",
    "packet_losses",
    "packet_delay",
    "estimate_error",
    "nees",
    "information_age",
    "navigation_drift",
]
SCENARIO: Any = SimpleNamespace(name="by_hand")


def talking_fleet(
    n: int = 4, n_ticks: int = 300, period_s: float = 0.5, *, airtime_s: float = 0.1
) -> Recording:
    """Vehicles at rest whose navigations drift; each sends one packet per second, and some are lost."""
    rng = np.random.default_rng(5)
    r = Recording.empty([f"auv_{i + 1}" for i in range(n)], period_s * np.arange(n_ticks + 1))
    r.position_ned_m[:] = rng.normal(0.0, 3.0, (n, 3))
    drift_m = 0.01 * r.t_s[:-1, np.newaxis, np.newaxis] * rng.normal(size=(n, 3))
    r.nav_position_ned_m[:] = r.position_ned_m[:-1] + drift_m
    r.nav_position_sd_m[:] = 0.01 * r.t_s[:-1, np.newaxis]
    estimate_m = r.position_ned_m[:-1, np.newaxis] + rng.normal(0.0, 0.1, (n_ticks, n, n, 3))
    r.neighbour_position_ned_m[:] = estimate_m + drift_m[:, :, np.newaxis]
    r.neighbour_velocity_ned_mps[:] = rng.normal(0.0, 0.1, (n_ticks, n, n, 3))
    r.neighbour_covariance[:] = 0.01 * np.eye(6)
    r.neighbour_age_s[:] = rng.uniform(0.1, 4.0, (n_ticks, n, n))
    r.neighbour_sonar_age_s[:] = np.inf
    r.sent = np.array([(k, i + 1, k) for k in range(0, n_ticks, 2) for i in range(n)])
    ends = np.array([(k + 1, i, j + 1, k) for k, i, _ in r.sent for j in range(n) if j + 1 != i])
    if not len(ends):
        return r
    outcomes = rng.choice([1, 1, 1, *range(2, 7)], len(ends))
    r.received = ends[outcomes == Outcome.DELIVERED]
    r.delay_s = airtime_s + rng.gamma(2.0, 0.01, len(r.received))
    r.events = np.column_stack(
        [ends[:, 0], outcomes, ends[:, 1], ends[:, 2], ends[:, 3], np.full(len(ends), 32)]
    )
    r.event_values = np.tile([0.0, airtime_s, 20.0], (len(ends), 1))
    return r


def acoustics_figures(
    recording: Recording, scenario: Any, folder: Path, *, only: Collection[str] | None = None
) -> list[Figure]:
    return list(save_figures(acoustics_drawers(recording, only=only), scenario, folder).figures)


def names(figures: list[Figure]) -> list[str]:
    return [figure.path.stem for figure in figures]


@pytest.mark.filterwarnings("error")
def test_every_figure_is_a_png_of_sane_size_with_words(tmp_path: Path) -> None:
    figures = acoustics_figures(talking_fleet(), SCENARIO, tmp_path / "figures")
    assert names(figures) == ALL
    for figure in figures:
        content = figure.path.read_bytes()
        width, height = struct.unpack(">II", content[16:24])
        assert 900 <= width <= 1400
        assert 400 <= height <= 1400
        assert 8_000 < len(content) < 1_000_000
        assert figure.title
        assert len(figure.caption) > 40


@pytest.mark.filterwarnings("error")
def test_no_figure_of_what_an_ideal_medium_and_an_exact_navigation_lack(tmp_path: Path) -> None:
    recording = talking_fleet(airtime_s=0.0)
    recording.nav_position_ned_m[:] = recording.position_ned_m[:-1]
    assert names(acoustics_figures(recording, SCENARIO, tmp_path)) == OF_ESTIMATES
    assert sorted(path.stem for path in tmp_path.iterdir()) == sorted(OF_ESTIMATES)


def test_a_recording_of_nothing_gives_no_figure(tmp_path: Path) -> None:
    recording = Recording.empty(["auv_1", "auv_2"], np.arange(10.0))
    assert acoustics_figures(recording, SCENARIO, tmp_path) == []


def test_one_vehicle_alone_has_a_navigation_only(tmp_path: Path) -> None:
    assert names(acoustics_figures(talking_fleet(1), SCENARIO, tmp_path)) == ["navigation_drift"]


@pytest.mark.filterwarnings("error")
def test_the_shortest_run(tmp_path: Path) -> None:
    assert names(acoustics_figures(talking_fleet(n_ticks=1), SCENARIO, tmp_path))


@pytest.mark.filterwarnings("error")
def test_lost_vehicles_and_missing_numbers_draw_without_complaint(tmp_path: Path) -> None:
    recording = talking_fleet()
    recording.lost_at_s[1] = 80.0
    recording.position_ned_m[50:60, 2] = np.nan
    recording.neighbour_covariance[100:120] = np.nan
    recording.nav_position_sd_m[20:30] = np.nan
    recording.neighbour_age_s[:40] = np.nan
    recording.neighbour_sonar_age_s[70:, 0, 1] = 0.3
    of_vehicles = ALL[3:]
    assert names(acoustics_figures(recording, SCENARIO, tmp_path, only=of_vehicles)) == of_vehicles


@pytest.mark.filterwarnings("error")
def test_twelve_vehicles_are_too_many_for_single_lines(tmp_path: Path) -> None:
    with_lines = ["packet_delivery", "packet_losses", "information_age", "navigation_drift"]
    figures = acoustics_figures(talking_fleet(12, 60), SCENARIO, tmp_path, only=with_lines)
    assert names(figures) == with_lines


def test_delays_over_decades_and_delays_all_alike(tmp_path: Path) -> None:
    recording = talking_fleet()
    recording.delay_s = np.geomspace(0.1, 20.0, len(recording.delay_s))
    assert names(acoustics_figures(recording, SCENARIO, tmp_path, only=["packet_delay"])) == ["packet_delay"]
    recording.delay_s[:] = 0.5
    assert acoustics_figures(recording, SCENARIO, tmp_path, only=["packet_delay"]) == []


def test_equal_runs_give_equal_files(tmp_path: Path) -> None:
    first, second = (
        acoustics_figures(talking_fleet(n_ticks=40), SCENARIO, tmp_path / x, only=["nees"]) for x in "ab"
    )
    assert [f.path.read_bytes() for f in first] == [f.path.read_bytes() for f in second]


@pytest.mark.parametrize("follows", ["velocity", "region", "path"])
def test_the_figures_of_every_run_end_with_those_of_its_network(monkeypatch: Any, follows: str) -> None:
    for name in ("flock_drawers", "region_drawers", "path_drawers"):
        monkeypatch.setattr(f"auv_experiment.figures.by_law.{name}", lambda *_, **__: {"of the law": None})
    monkeypatch.setattr("auv_experiment.figures.by_law.thruster_drawers", lambda *_: {})
    monkeypatch.setattr("auv_experiment.figures.by_law.acoustics_drawers", lambda _: {"of the network": None})
    scenario: Any = SimpleNamespace(follows=follows, vehicles=())
    figures = list(run_drawers(talking_fleet(2, 4), scenario))
    assert figures[0] == "of the law"
    assert figures[-1] == "of the network"
