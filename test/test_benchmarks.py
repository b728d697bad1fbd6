"""The benchmark's runner and its parts work; what they measure is for people to judge."""

import json
import sys
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest

from auv_core import compiled

sys.path.insert(0, str(Path(__file__).parents[1]))
from benchmarks import __main__ as runner
from benchmarks.peers import Peer
from benchmarks.rows import Row, spread, taking_turns


def test_a_table_and_files_come_out(tmp_path, monkeypatch, capsys):
    rows = [
        Row("speed", "3", "limit: 1", "3.0", "at least 2", kept=True),
        Row("size", "9", bar="at most 8", kept=False),
    ]
    part = SimpleNamespace(rows=lambda *, quick: rows if quick else [])
    monkeypatch.setitem(sys.modules, "benchmarks.kernel", part)
    assert runner.main(["--only", "kernel", "--quick", "--out", str(tmp_path)]) == 0
    out = capsys.readouterr()
    assert "| speed | 3 | limit: 1 | 3.0 | at least 2 | yes |" in out.out
    assert "| size | 9 |  |  | at most 8 | NO |" in out.out
    assert "kernel: speed: 3" in out.err
    written = json.loads((tmp_path / "benchmarks.json").read_text())
    assert [(row["part"], row["figure"], row["kept"]) for row in written] == [
        ("kernel", "speed", True),
        ("kernel", "size", False),
    ]
    assert (tmp_path / "benchmarks.md").read_text() == out.out


def test_a_part_that_is_none_is_refused(capsys):
    with pytest.raises(SystemExit, match="2"):
        runner.main(["--only", "everything"])
    assert "invalid choice: 'everything'" in capsys.readouterr().err


def test_the_kernel_flies_any_number_from_where_it_began(monkeypatch):
    from benchmarks.kernel import FleetRun

    monkeypatch.setattr(compiled, "_is_on", False)
    compiled.use_compiler()
    flight = FleetRun(300, ticks=10)
    flight.fly()
    first = flight._fleet.motion.copy()
    flight.fly()
    assert (flight._fleet.motion == first).all()
    assert flight.rate(0.0) > 0.0


def test_the_loop_with_laws_flies_the_scenario_to_the_last_bit(monkeypatch):
    from auv_experiment.inprocess.sampled import run_in_process
    from auv_experiment.scenario.loading import load_scenario
    from benchmarks.torpedo_loop import TorpedoRun

    monkeypatch.setattr(compiled, "_is_on", False)
    job = load_scenario("torpedo_path", duration_s=20.0)
    recording = run_in_process(job)
    end = TorpedoRun(job).fly()
    assert end[:3] == tuple(recording.position_ned_m[-1, 0])
    assert end[3:7] == tuple(recording.attitude_quat_wxyz[-1, 0])
    assert end[7:13] == tuple(recording.velocity_body[-1, 0])


def test_a_peer_that_is_not_there_is_told():
    with Peer("auv_sim_bench", 4, None) as peer:
        assert peer.absent == "not asked for (--peers)"
    with Peer("auv_sim_bench", 4, Path(sys.executable)) as peer:
        assert peer.absent == "not in .venv-peers"


def test_blocks_take_turns():
    order = []

    def measure(name, rate):
        order.append(name)
        return rate

    found = taking_turns([partial(measure, "a", 1.0), partial(measure, "b", 2.0)], 3)
    assert order == ["a", "b"] * 3
    assert found == [[1.0] * 3, [2.0] * 3]
    assert spread([3.0, 1.0, 2.0]) == "2 [1..3]"
