"""Claims about flying sweeps: each run once, kept, the same on any host; a worker that dies is noticed."""

import contextlib
import functools
import io
import math
import multiprocessing
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import psutil
import pyarrow.parquet as pq
import pytest
import yaml
from distributed import Client, LocalCluster
from full_disk import files_of_at_most

import auv_flocking.separation
from auv_core.cli.tally import Tally
from auv_core.machine import workers
from auv_experiment.inprocess import evaluated_run
from auv_experiment.run_key import source_version
from auv_experiment.sweeps import cli, cluster, local, parts, worker
from auv_experiment.sweeps.patience import Patience
from auv_experiment.sweeps.plan import plan_runs
from auv_experiment.sweeps.runner import run_sweep
from auv_experiment.sweeps.study import study_from_plain
from auv_experiment.sweeps.table import WALL_CLOCK_COLUMNS
from auv_experiment.sweeps.worker import Finished, SourceMismatchError, fly_run

LOSS = "acoustics.outage.params.loss_prob"
VEHICLES = [{"id": f"auv_{k}", "model": {"preset": "odin"}} for k in (1, 2)]
TINY = {
    "schema": 1,
    "name": "tiny",
    "title": "Tiny",
    "scenario": "flock_modem",
    "duration_s": 4.0,
    "overrides": {"vehicles": VEHICLES},
    "grid": {LOSS: [0.0, 0.5]},
    "seeds": [1, 2, 3],
    "metrics": ["packet_delivery_ratio"],
}
WAIT_S = 60.0
SINKING = """
from auv_flocking.separation.mathematical import Params

class Separation:
    def __init__(self, params):
        pass

    def velocity(self, own, other, spacing_m):
        {deed}
"""
RAISES = SINKING.format(deed='raise LookupError("it\\nsank")')
KILLS = SINKING.format(deed="__import__('os').kill(__import__('os').getpid(), 9)")


def in_threads(runs, on_result, on_message):
    """Fly runs on a cluster of threads in this process, which tests can reach into."""
    with threads() as client:
        cluster.fly_with(client, runs, on_result, on_message)


in_processes = functools.partial(local.fly_here, n_workers=2)


@contextlib.contextmanager
def threads(n=1):
    """Yield a cluster of threads in this process."""
    here = {"protocol": "tcp://", "host": "127.0.0.1", "dashboard_address": None}
    any_port = {"dashboard_address": "127.0.0.1:0"}
    with (
        LocalCluster(
            processes=False, n_workers=n, threads_per_worker=1, scheduler_kwargs=any_port, **here
        ) as workers,
        Client(workers, set_as_default=False) as client,
    ):
        yield client


def sweep(folder, fly=in_threads, is_fresh=False, **changes):
    """Fly a study; return its table as rows, and its output."""
    study = study_from_plain({**TINY, **changes})
    folder.mkdir(exist_ok=True)
    stream = io.StringIO()
    with Tally("runs", stream) as tally:
        run_sweep(study, plan_runs(study), folder, fly, tally=tally, is_fresh=is_fresh)
    return rows_of(folder), stream.getvalue()


def table_of(folder):
    return pq.read_table(folder / "runs.parquet").drop_columns(list(WALL_CLOCK_COLUMNS))


def rows_of(folder):
    return table_of(folder).to_pylist()


@pytest.fixture
def flights(monkeypatch):
    """Count flights in this process by seed."""
    seeds = []
    fly_truly = evaluated_run.run_evaluated

    def counted(scenario):
        seeds.append(scenario.seed)
        return fly_truly(scenario)

    monkeypatch.setattr(worker, "run_evaluated", counted)
    return seeds


def test_a_table_has_one_row_per_run_with_parameters_seed_and_every_metric(tmp_path):
    rows, _ = sweep(tmp_path)
    found = [(row["run"], row[f"scenario.{LOSS}"], row["seed"], row["status"]) for row in rows]
    expected = [(loss, seed) for loss in (0.0, 0.5) for seed in (1, 2, 3)]
    assert found == [(index, *pair, "done") for index, pair in enumerate(expected)]
    runs = plan_runs(study_from_plain(TINY))
    for row, run in zip(rows, runs, strict=True):
        flown = fly_run(run.scenario_json, source_version())
        assert {key: row[key] for key in flown.metrics} == flown.metrics


def test_what_is_done_is_not_flown_again(tmp_path, flights):
    first, _ = sweep(tmp_path, seeds=[1, 3])
    both, words = sweep(tmp_path)
    assert sorted(flights) == [1, 1, 2, 2, 3, 3]
    assert "runs: 2, and 4 kept from an earlier call" in words
    assert [row["pair_distance_min_m"] for row in both if row["seed"] != 2] == [
        row["pair_distance_min_m"] for row in first
    ]
    sweep(tmp_path, fly=lambda *_: pytest.fail("there is nothing to fly"))
    sweep(tmp_path, is_fresh=True)
    assert len(flights) == 12


def test_a_sweep_that_breaks_off_loses_only_what_was_in_flight(tmp_path, flights, monkeypatch):
    keep_truly = parts.Parts.put

    def keep_two(self, key, finished):
        if len(list(self._folder.glob("*.json"))) == 2:
            raise KeyboardInterrupt
        keep_truly(self, key, finished)

    with monkeypatch.context() as patched:
        patched.setattr(parts.Parts, "put", keep_two)
        with pytest.raises(KeyboardInterrupt):
            sweep(tmp_path)
    assert not (tmp_path / "runs.parquet").exists()
    flights.clear()
    rows, _ = sweep(tmp_path)
    assert len(flights) == 4
    assert {row["status"] for row in rows} == {"done"}


def test_kept_runs_that_were_changed_are_flown_again_with_one_warning(tmp_path, flights):
    before, _ = sweep(tmp_path)
    flights.clear()
    flipped, cut, *_ = sorted(tmp_path.glob("parts/*/*.json"))
    flipped.write_text(flipped.read_text().replace('"is_lasting": true', '"is_lasting": false'))
    cut.write_text(cut.read_text()[:100])
    after, words = sweep(tmp_path)
    assert after == before
    assert len(flights) == 2
    (line,) = [line for line in words.splitlines() if "warning" in line]
    assert line.startswith("warning: kept runs were changed or damaged and are flown again: ")
    assert line.endswith(") and 1 more")
    _, words = sweep(tmp_path, fly=lambda *_: pytest.fail("they hold again"))
    assert "warning" not in words


def test_a_full_disk_ends_a_sweep_in_one_line_and_the_next_call_goes_on(tmp_path, monkeypatch, capsys):
    keep_truly = parts.Parts.put

    def keep_two(self, key, finished):
        if len(list(self._folder.glob("*.json"))) < 2:
            return keep_truly(self, key, finished)
        with files_of_at_most(10):
            return keep_truly(self, key, finished)

    command = [str(written(tmp_path)), "--out", str(tmp_path / "out"), "--workers", "2"]
    with monkeypatch.context() as patched:
        patched.setattr(parts.Parts, "put", keep_two)
        assert cli.main(command) == 3
    assert capsys.readouterr().err.splitlines()[-1].startswith("error: cannot write ")
    assert len([path for path in (tmp_path / "out").rglob("*") if path.is_file()]) == 2
    assert cli.main(command) == 0
    assert "runs: 4, and 2 kept from an earlier call" in capsys.readouterr().err


def test_another_source_flies_again_and_the_old_runs_go(tmp_path, flights, monkeypatch):
    sweep(tmp_path)
    for module in ("auv_experiment.run_key", "auv_experiment.sweeps.parts", "auv_experiment.sweeps.cluster"):
        monkeypatch.setattr(f"{module}.source_version", lambda: "other")
    monkeypatch.setattr(worker, "source_version", lambda: "other")
    sweep(tmp_path)
    assert len(flights) == 12
    assert [path.name for path in (tmp_path / "parts").iterdir()] == ["other"]


def test_points_that_are_one_scenario_are_flown_once_and_have_a_row_each(tmp_path, flights):
    rows, _ = sweep(tmp_path, grid={LOSS: [0, 0.0]})
    assert sorted(flights) == [1, 2, 3]
    assert [row["seed"] for row in rows] == [1, 2, 3, 1, 2, 3]


def test_a_run_that_raises_is_a_row_and_its_traceback_is_kept(tmp_path, flights, monkeypatch):
    plugin(monkeypatch, tmp_path, "raises", RAISES)
    grid = {"agent.separation.kind": ["mathematical", "raises"]}
    rows, words = sweep(tmp_path / "out", grid=grid, seeds=[1])
    assert [(row["status"], row["error"]) for row in rows] == [
        ("done", ""),
        ("failed", "LookupError: it sank"),
    ]
    assert rows[1]["packet_delivery_ratio"] is None
    assert "error: run 1 (agent.separation.kind=raises, seed=1): LookupError: it sank" in words
    text = (tmp_path / "out/failures.txt").read_text()
    assert text.startswith("== run 1 (agent.separation.kind=raises, seed=1)\nTraceback")
    flights.clear()
    sweep(tmp_path / "out", grid=grid, seeds=[1])
    assert flights == [], "it would raise again"


def plugin(monkeypatch, folder, name, text):
    """Put a separation law into a plugin folder."""
    place = folder / "plugins/separation"
    place.mkdir(parents=True)
    (place / f"{name}.py").write_text(text)
    monkeypatch.setenv("SHOAL_PLUGINS", str(place.parent))
    source_version.cache_clear()
    monkeypatch.setattr("auv_flocking.separation.__path__", list(auv_flocking.separation.__path__))
    monkeypatch.setitem(sys.modules, f"auv_flocking.separation.{name}", None)
    del sys.modules[f"auv_flocking.separation.{name}"]


@pytest.fixture(autouse=True)
def _fresh_source():
    yield
    source_version.cache_clear()


def test_a_worker_with_another_source_flies_nothing(tmp_path):
    (run,) = plan_runs(study_from_plain({**TINY, "grid": None, "seeds": [1]}))
    with pytest.raises(SourceMismatchError, match="a worker has other source or packages"):
        fly_run(run.scenario_json, "other")


def test_a_worker_with_another_source_ends_the_sweep_in_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "source_version", lambda: "0123")
    with pytest.raises(
        cluster.ClusterError, match=r"^a worker has other source or packages \(\w+\) than .* \(0123\)"
    ):
        sweep(tmp_path)


@pytest.mark.parametrize(
    "where", ["tcp://127.0.0.1:9", "tls://127.0.0.1:9", "nonsense", "foo://here:1", "gone.json", "tiny.json"]
)
def test_a_scheduler_that_is_not_there_is_told_in_one_line(where, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(cluster, "_CONNECT_TIMEOUT_S", 0.5)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.json").write_text("{}")
    assert cli.main([str(written(tmp_path)), "--out", "out", "--scheduler", where]) == 2
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith(f"error: --scheduler {where!r}: cannot be reached (")


def written(folder, **changes):
    path = folder / "tiny.yaml"
    path.write_text(yaml.safe_dump({**TINY, **changes}))
    return path


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_worker_that_is_killed_or_stopped_changes_nothing(tmp_path, monkeypatch, number):
    """Two processes, one of them hit in the middle, give what one thread gives."""
    monkeypatch.setattr(workers, "_LOOK_EVERY_S", 0.1)
    hit: list[Any] = []

    def one_is_hit(runs, on_result, on_message):
        def hit_and_keep(run, finished):
            if not hit:
                hit.append(multiprocessing.active_children()[0].pid)
                os.kill(hit[0], number)
            on_result(run, finished)

        in_processes(runs, hit_and_keep, on_message)

    _, words = sweep(tmp_path / "two", one_is_hit)
    sweep(tmp_path / "one")
    assert not Path("/proc", str(hit[0])).exists()
    assert (f"worker process {hit[0]} has been stopped" in words) == (number == signal.SIGSTOP)
    assert table_of(tmp_path / "two").equals(table_of(tmp_path / "one"), check_metadata=True)


def test_workers_that_cannot_start_are_told_in_one_line_and_the_next_call_goes_on(
    tmp_path, monkeypatch, capsys
):
    command = [str(written(tmp_path)), "--out", str(tmp_path / "out"), "--workers", "2"]
    with monkeypatch.context() as patched:
        patched.setattr(workers, "_become_worker", lambda parent: os.kill(os.getpid(), signal.SIGKILL))
        assert cli.main(command) == 1
    assert capsys.readouterr().err.splitlines()[-1] == (
        "error: all of 6 worker processes ended while they started; finished runs are kept for the next call"
    )
    assert cli.main(command) == 0


def test_nobody_can_hand_a_run_to_a_sweep_on_this_machine(tmp_path):
    """Neither the sweep nor its workers listen anywhere, so no process, of whatever user, can connect."""
    listening: list[Any] = []

    def look(runs, on_result, on_message):
        def look_and_keep(run, finished):
            for process in [psutil.Process(), *psutil.Process().children()]:
                listening.extend(c for c in process.net_connections("all") if is_open_to_others(c))
            on_result(run, finished)

        in_processes(runs, look_and_keep, on_message)

    before = [c for c in psutil.Process().net_connections("all") if is_open_to_others(c)]
    sweep(tmp_path, look)
    assert set(listening) <= set(before)


def is_open_to_others(found):
    """Return whether a socket has a name for others to connect to; those of a socket pair have none."""
    return bool(found.laddr) and not found.raddr


def test_a_run_that_never_ends_is_a_failed_row_and_the_next_call_tries_it_again(
    tmp_path, monkeypatch, capsys
):
    def looping(scenario_json, source):
        while '"seed": 2' in scenario_json:
            pass
        return Finished({"packet_delivery_ratio": 1.0}, wall_s=0.1, cpu_s=0.1)

    monkeypatch.setattr(local, "fly_run", looping)
    command = [str(written(tmp_path)), "--out", str(tmp_path / "out"), "--workers", "2", "--limit-s", "2"]
    for flown in ("runs: 6", "runs: 2, and 4 kept"):
        assert cli.main(command) == 1
        errors = capsys.readouterr().err
        assert flown in errors
        lines = [line for line in errors.splitlines() if "took longer than 2 s, and was ended" in line]
        assert len(lines) == 2
        failed = [row for row in rows_of(tmp_path / "out") if row["status"] == "failed"]
        assert [row["seed"] for row in failed] == [2, 2]


def test_patience_follows_from_what_others_took_and_from_the_effort():
    short, long = (replace(plan_runs(study_from_plain(TINY))[0], effort=effort) for effort in (10.0, 1e4))
    patience = Patience()
    assert patience.limit_s(short) == math.inf
    patience.note(short, Finished({}, "it sank", "it sank"))
    assert patience.limit_s(short) == math.inf
    for wall_s in (0.5, 1.0, 90.0):
        patience.note(short, Finished({}, wall_s=wall_s))
    assert patience.limit_s(short) == 300.0
    assert patience.limit_s(long) == pytest.approx(20 * 1000.0)
    assert Patience(7.0).limit_s(long) == 7.0


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--limit-s", "x"], "--limit-s: 'x' is not allowed; allowed: a number of seconds, at least 1"),
        (["--limit-s", "nan"], "--limit-s: 'nan' is not allowed; allowed: a number of seconds, at least 1"),
        (["--limit-s", "0.5"], "--limit-s: '0.5' is not allowed; allowed: a number of seconds, at least 1"),
        (["--limit-s", "9", "--scheduler", "tcp://127.0.0.1:1"], "--limit-s 9: not allowed with --scheduler"),
    ],
)
def test_a_limit_that_cannot_be_is_one_line(tmp_path, capsys, arguments, line):
    status: Any
    try:
        status = cli.main([str(written(tmp_path)), *arguments])
    except SystemExit as ended:
        status = ended.code
    assert status == 2
    (error,) = capsys.readouterr().err.splitlines()
    assert line in error


def test_two_sweeps_never_fly_into_one_folder(tmp_path, monkeypatch, capsys):
    out = tmp_path / "out"
    command = [str(written(tmp_path)), "--out", str(out), "--workers", "1"]
    again = []

    def fly(runs, on_result, on_message, **_):
        again.append(
            subprocess.run([sys.executable, "-m", cli.__name__, *command], capture_output=True, text=True)
        )
        local_fly(runs, on_result, on_message, n_workers=1)

    local_fly = local.fly_here
    monkeypatch.setattr(local, "fly_here", fly)
    assert cli.main(command) == 0
    (second,) = again
    assert second.returncode == 2
    assert second.stderr == (
        f"error: --out {str(out)!r}: another sweep is flying into it; allowed: a folder of its own\n"
    )
    capsys.readouterr()
    assert cli.main(command) == 0  # when it has ended, the folder is free again


@pytest.mark.slow
def test_a_run_that_kills_its_workers_fails_alone(tmp_path, monkeypatch):
    plugin(monkeypatch, tmp_path, "kills", KILLS)
    grid = {"agent.separation.kind": ["mathematical", "kills"]}
    rows, _ = sweep(tmp_path / "out", in_processes, grid=grid)
    assert [row["status"] for row in rows] == ["done"] * 3 + ["failed"] * 3
    assert all("its worker process died every time" in row["error"] for row in rows[3:])
    assert len(list(tmp_path.glob("out/parts/*/*.json"))) == 3, "it is tried again by the next call"


@pytest.mark.slow
@pytest.mark.parametrize("address", ["address", "scheduler file"])
def test_a_cluster_that_exists_gives_the_same_table(tmp_path, address):
    file = tmp_path / "scheduler.json"
    with running("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", file=file):
        wait_until(file.exists)
        with running("dask_worker", "--nthreads", "1", "--host", "127.0.0.1", "--no-dashboard", file=file):
            where = str(file) if address == "scheduler file" else yaml.safe_load(file.read_text())["address"]
            sweep(tmp_path / "there", functools.partial(cluster.fly_there, scheduler=where))
    sweep(tmp_path / "here")
    assert table_of(tmp_path / "there").equals(table_of(tmp_path / "here"), check_metadata=True)


@pytest.mark.slow
def test_a_scheduler_that_goes_away_is_told_and_what_is_finished_is_kept(tmp_path):
    file = tmp_path / "scheduler.json"
    with running(
        "dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", file=file
    ) as scheduler:
        wait_until(file.exists)
        with running("dask_worker", "--nthreads", "1", "--host", "127.0.0.1", "--no-dashboard", file=file):

            def it_goes(*arguments):
                threading.Thread(target=kill_after_first, args=(scheduler, tmp_path)).start()
                cluster.fly_there(*arguments, scheduler=str(file))

            with pytest.raises(cluster.ClusterError, match="the scheduler is gone"):
                sweep(tmp_path / "out", it_goes, duration_s=60.0)
    rows, _ = sweep(tmp_path / "out", duration_s=60.0)
    assert len(rows) == 6


@pytest.mark.slow
def test_a_scheduler_that_is_stopped_is_told_in_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "_LOOK_EVERY_S", 0.5)
    monkeypatch.setattr(cluster, "_ANSWER_TIMEOUT_S", 2.0)
    file = tmp_path / "scheduler.json"
    with running(
        "dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", file=file
    ) as scheduler:
        wait_until(file.exists)

        def it_stops(*arguments):
            scheduler.send_signal(signal.SIGSTOP)
            cluster.fly_with(*arguments)

        with (
            cluster.remote_client(str(file)) as client,
            pytest.raises(cluster.ClusterError, match=r"^the scheduler has not answered for 2 s$"),
        ):
            sweep(tmp_path / "out", lambda *arguments: it_stops(client, *arguments))


@pytest.mark.slow
def test_a_worker_of_a_cluster_that_is_stopped_is_named_and_its_runs_are_flown(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "_LOOK_EVERY_S", 1.0)
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL", "10s")
    file, here = tmp_path / "scheduler.json", ("--host", "127.0.0.1", "--no-dashboard")
    with running("dask_scheduler", "--port", "0", *here, file=file):
        wait_until(file.exists)
        with running("dask_worker", "--nthreads", "1", *here, file=file) as nanny:
            stopped: list[Any] = []

            def one_is_stopped(runs, on_result, on_message):
                def stop_and_keep(run, finished):
                    if not stopped:
                        stopped.extend(psutil.Process(nanny.pid).children())
                        for process in stopped:
                            process.suspend()
                    on_result(run, finished)

                cluster.fly_there(runs, stop_and_keep, on_message, scheduler=str(file))

            rows, words = sweep(tmp_path / "out", one_is_stopped, duration_s=60.0)
    assert words.count("is silent; the scheduler gives its runs to others") >= 1
    assert {row["status"] for row in rows} == {"done"}


STRANGER = """
import os, sys
from distributed import Client
if os.getuid() == 0:
    os.setgid(65534)
    os.setuid(65534)
try:
    Client(sys.argv[1], timeout=3).submit(print, "it ran").result(timeout=10)
except Exception as error:
    sys.exit(f"{type(error).__name__}: kept out")
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("openssl") is None, reason="makes certificates with openssl")
def test_a_cluster_with_certificates_flies_and_keeps_another_user_without_them_out(tmp_path, monkeypatch):
    """Certificates and configuration are those of docs/how_to/sweeps.md."""
    text = (Path(__file__).parents[3] / "docs/how_to/sweeps.md").read_text(encoding="utf-8")
    ((make, config),) = re.findall(r"(openssl [^\n]+).*```yaml\n(distributed:.*?)```", text, re.DOTALL)
    subprocess.run(make.split(), check=True, capture_output=True, cwd=tmp_path)
    (tmp_path / "dask.yaml").write_text(config.replace("/home/me", str(tmp_path)))
    file, here = tmp_path / "scheduler.json", ("--protocol", "tls", "--host", "127.0.0.1", "--no-dashboard")
    monkeypatch.setenv("DASK_CONFIG", str(tmp_path / "dask.yaml"))
    with running("dask_scheduler", "--port", "0", *here, file=file):
        wait_until(file.exists)
        address = yaml.safe_load(file.read_text())["address"]
        assert address.startswith("tls://")
        with running("dask_worker", "--nthreads", "1", *here, file=file):
            assert sweep_command(written(tmp_path), "--scheduler", address).wait(WAIT_S) == 0
            monkeypatch.delenv("DASK_CONFIG")
            for other in (address, address.replace("tls://", "tcp://")):
                stranger = subprocess.run(
                    [sys.executable, "-c", STRANGER, other],
                    capture_output=True,
                    text=True,
                    timeout=WAIT_S,
                )
                assert stranger.stderr.splitlines()[-1].endswith("kept out"), stranger.stderr
            assert "it ran" not in (tmp_path / "dask_worker.log").read_text()
    assert {row["status"] for row in rows_of(tmp_path / "out")} == {"done"}


def kill_after_first(process, folder):
    wait_until(lambda: list(folder.glob("out/parts/*/*.json")))
    process.kill()


@contextlib.contextmanager
def running(module, *arguments, file):
    """Run a command of Dask in a session of its own."""
    environ = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    command = [sys.executable, "-m", f"distributed.cli.{module}", "--scheduler-file", str(file), *arguments]
    with (file.parent / f"{module}.log").open("wb") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log, env=environ, start_new_session=True)
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait(WAIT_S)


def sweep_command(path, *options):
    """Start a sweep of a study into the folder `out` beside it, in a session of its own."""
    environ = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    command = [
        sys.executable,
        "-m",
        "auv_experiment.sweeps.cli",
        str(path),
        "--out",
        str(path.parent / "out"),
    ]
    with (path.parent / "log").open("wb") as stream:
        return subprocess.Popen(
            [*command, *options], stdout=stream, stderr=stream, env=environ, start_new_session=True
        )


@pytest.fixture
def long_command(tmp_path):
    """Start a sweep that takes long; give it when its first run is kept."""
    path = written(tmp_path, duration_s=200.0, seeds=list(range(20)))
    process = sweep_command(path, "--workers", "2")
    try:
        wait_until(lambda: list(tmp_path.glob("out/parts/*/*.json")))
        yield process, tmp_path / "log"
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait(WAIT_S)


def members(session):
    """Return the processes of a session that still run."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            fields = (path / "stat").read_text().rpartition(")")[2].split()
            if int(fields[3]) == session and fields[0] != "Z":
                found.append(int(path.name))
    return found


def wait_until(condition):
    event = threading.Event()
    for _ in range(int(WAIT_S / 0.05)):
        if condition():
            return
        event.wait(0.05)
    raise AssertionError("it did not happen in time")


@pytest.mark.slow
@pytest.mark.parametrize("send", [os.kill, os.killpg], ids=["to the command", "to all, as a terminal does"])
def test_ctrl_c_ends_it_in_one_line_and_leaves_no_process(long_command, send):
    process, log = long_command
    send(process.pid, signal.SIGINT)
    assert process.wait(WAIT_S) == 130
    wait_until(lambda: members(process.pid) == [])
    *_, last = log.read_text().splitlines()
    assert last == "error: interrupted; finished runs are kept for the next call"
    assert "Traceback" not in log.read_text()


@pytest.mark.slow
def test_a_killed_command_leaves_no_process_and_what_it_has_finished(long_command, tmp_path):
    process, _ = long_command
    process.kill()
    process.wait(WAIT_S)
    wait_until(lambda: members(process.pid) == [])
    _, words = sweep(tmp_path / "out", duration_s=200.0, seeds=list(range(3)), grid={LOSS: [0.0]})
    assert "kept from an earlier call" in words


def hit_at_random(command, rng, hits, most):
    """Kill or stop a worker, or kill the command, at random moments until it ends or `most` hits are made."""
    pause = threading.Event()
    while command.poll() is None:
        pause.wait(rng.uniform(0.0, 1.0))
        if hits.total() >= most:
            continue
        (hit,) = rng.choices(["worker killed", "worker stopped", "command killed"], weights=(6, 3, 1))
        with contextlib.suppress(psutil.NoSuchProcess, IndexError):
            process = psutil.Process(command.pid)
            target = process if hit == "command killed" else rng.choice(process.children())
            target.send_signal(signal.SIGSTOP if hit == "worker stopped" else signal.SIGKILL)
            hits[hit] += 1


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_hostile_hits_on_command_and_workers_change_nothing_in_the_table(tmp_path, capsys):
    changes = {"duration_s": 120.0, "seeds": list(range(30))}
    path, rng = written(tmp_path, **changes), random.Random(1)
    hits: Counter[str] = Counter()
    statuses: list[Any] = []
    while not statuses or statuses[-1] != 0:
        command = sweep_command(path, "--workers", "2")
        hit_at_random(command, rng, hits, most=60)
        statuses.append(command.returncode)
        wait_until(functools.partial(nobody_runs, command.pid))
    assert set(statuses) <= {0, 1, -signal.SIGKILL}
    with capsys.disabled():
        sys.stdout.write(f"\n{dict(hits)}, {len(statuses)} calls\n")
    sweep(tmp_path / "undisturbed", in_processes, **changes)
    assert table_of(tmp_path / "out").equals(table_of(tmp_path / "undisturbed"), check_metadata=True)


def nobody_runs(session):
    return members(session) == []
