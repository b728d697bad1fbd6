"""
Claims about a recording of a tree before version 4 of `compact`.

`run_with_compact_3.tar.xz` is a real run: two vehicles of `flock_acoustic` with dead reckoning and fixes, 7 s
in lock-step, reports of version 3, and state messages without `bounded`.
"""

import json
import tarfile
from pathlib import Path
from typing import Any

import pytest

from auv_bag.bag import Bag
from auv_bringup.tools import replay, run
from auv_experiment.compose import agent_configs
from auv_experiment.re_estimate import re_estimate
from auv_experiment.scenario.loading import load_scenario
from auv_flocking.agent_config import report_format
from auv_flocking.senses import senses_of

# Older releases of Python 3.11 have no filters.
_SAFELY: dict[str, Any] = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}


@pytest.fixture
def recorded(tmp_path):
    with tarfile.open(Path(__file__).parent / "run_with_compact_3.tar.xz") as archive:
        archive.extractall(tmp_path, **_SAFELY)
    return tmp_path


def test_its_reports_are_decoded(recorded):
    scenario = load_scenario(str(recorded / "scenario.yaml"))
    form = report_format(scenario.agent, len(scenario.vehicles))
    bag = Bag(recorded)
    reports = [
        form.decode(reception.packet.payload.tobytes(), 0.1 * inbox.tick)
        for inbox in map(bag.decode, bag.messages({"/auv_1/acoustic/rx"}))
        for reception in inbox.receptions
    ]
    assert len(reports) == 10
    assert {report.address for report in reports} == {2}
    assert all(0.0 <= report.time_s <= 7.0 and report.is_bounded is None for report in reports)
    assert {report.position_sd_m > 0.0 for report in reports} == {True}


def test_its_estimates_are_made_again_from_its_packets(recorded, capsys):
    """Up to what the filter has learnt since; without the packets no estimate would have a partner."""
    scenario = load_scenario(str(recorded / "scenario.yaml"))
    senses = [senses_of(config) for config in agent_configs(scenario)]
    ids = [vehicle.id for vehicle in scenario.vehicles]
    result = re_estimate(Bag(recorded), ids, senses, scenario.period_s)
    assert (result.estimates, result.unmatched, result.unused_ticks) == (135, 0, 0)
    assert result.position_m < 0.5
    assert replay.main([str(recorded), "--re-estimate"]) in (0, 1)
    assert "135 estimates of 2 vehicles" in capsys.readouterr().out


def test_its_report_is_made_again_with_the_same_numbers(recorded):
    before = json.loads((recorded / "metrics.json").read_text(encoding="utf-8"))
    assert run.main(["--report", str(recorded), "--no-figures"]) == 0
    after = json.loads((recorded / "metrics.json").read_text(encoding="utf-8"))
    for name in (
        "vehicles",
        "collision",
        "pair_distance_min_m",
        "packets_sent",
        "packets_lost",
        "packet_delay_mean_s",
    ):
        assert after[name] == before[name]
    assert "<table" in (recorded / "report.html").read_text(encoding="utf-8")
