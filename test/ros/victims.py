"""One run with one process of it killed or stopped at a random moment, and what must hold afterwards."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from auv_bringup.launching.status_listener import EAR, EAR_MODULE
from auv_core.machine.process_states import children_of

NAMED_WITHIN_S = 5.0
RUN_LIMIT_S = 90.0
REPORT_LIMIT_S = 60.0
LONGEST_WAIT_S = 6.0
"""A run is hit at most this long after its command: start-up takes the first seconds of it."""
SHM = Path("/dev/shm")

_MARK = "SHOAL_TEST_RUN"
_PAIR = """
schema: 1
name: pair
title: "Two vehicles on a lossy channel"
duration_s: 3000.0
vehicles:
  - {id: auv_1, model: {preset: odin}, position_ned_m: [0.0, 10.0, 10.0]}
  - {id: auv_2, model: {preset: odin}, position_ned_m: [-3.0, 12.0, 10.0]}
leaders: [auv_1]
reference: {kind: circle}
agent:
  controller: {kind: velocity_pi}
acoustics: {preset: lossy}
"""


@dataclass
class Trial:
    """An attack on a run (`signal_name` to a process of the kind `victim`), and its outcome."""

    mode: str
    layout: str
    seed: int
    victim: str = ""
    signal_name: str = ""
    moment_s: float = 0.0
    named_after_s: float | None = None
    status: int | None = None
    faults: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        named = "-" if self.named_after_s is None else f"{self.named_after_s:.1f} s"
        return (
            f"{self.mode} {self.layout} #{self.seed}: {self.signal_name} to {self.victim} at "
            f"{self.moment_s:.1f} s, named after {named}, status {self.status}"
            + "".join(f"\n    {fault}" for fault in self.faults)
        )


class HitRun:
    """A run command, its processes, and its output."""

    def __init__(self, folder: Path, trial: Trial) -> None:
        folder.mkdir(parents=True)
        self._folder = str(folder)
        self._mark = f"{os.getpid()}-{trial.mode}-{trial.layout}-{trial.seed}"
        (folder / "pair.yaml").write_text(_PAIR)
        self.out = folder / "results"
        self._said = folder / "said.txt"
        with self._said.open("wb") as stream:
            self.process = subprocess.Popen(
                _command(
                    folder / "pair.yaml", "--mode", trial.mode, "--layout", trial.layout, "--out", self.out
                ),
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=stream,
                env={**os.environ, _MARK: self._mark},
            )

    @property
    def said(self) -> str:
        """Everything that the command has printed."""
        return self._said.read_text(errors="replace")

    def processes(self) -> dict[int, str]:
        """Return the command lines of nodes, launcher's ear and writer of the bag, by process id."""
        found = {}
        for entry in Path("/proc").iterdir():
            if entry.name.isdecimal() and int(entry.name) != self.process.pid:
                words = self._words(entry)
                if words:
                    found[int(entry.name)] = words
        return found

    def _words(self, entry: Path) -> str:
        """Return the command line of a process of this run, '' for any other."""
        try:
            words = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
            # A forked node has written its command line over its environment.
            is_node = "node_container" in words and self._folder in words
            is_ear = EAR_MODULE in words and int(entry.name) in children_of(self.process.pid)
            is_writer = "auv_bag.process" in words and self._mark in (entry / "environ").read_text(
                errors="replace"
            )
        except OSError:
            return ""
        return words if is_node or is_ear or is_writer else ""

    def end(self) -> None:
        """Kill whatever is left, also a process that was stopped."""
        for pid in [self.process.pid, *self.processes()]:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                continue
        self.process.wait(10.0)


def _command(*arguments: object) -> list[str]:
    """Return the run command with these arguments, without figures."""
    return [sys.executable, "-m", "auv_bringup.tools.run", *map(str, arguments), "--no-figures"]


def until(condition, limit_s: float) -> bool:
    """Wait until a condition holds; return whether it did within the limit."""
    pause, deadline_s = threading.Event(), time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > deadline_s:
            return False
        pause.wait(0.02)
    return True


def segments() -> set[Path]:
    """Return the files of Fast DDS in shared memory, and no tracer's."""
    return {path for path in SHM.iterdir() if "fastrtps" in path.name}


def hit(folder: Path, trial: Trial) -> Trial:
    """Fly, hit one process, and note every invariant that does not hold."""
    before = segments()
    run = HitRun(folder, trial)
    try:
        _strike_and_watch(run, trial)
        trial.status = run.process.poll()
        _judge_end(run, trial, before)
        _judge_results(run, trial)
    finally:
        run.end()
    return trial


def _strike_and_watch(run: HitRun, trial: Trial) -> None:
    rng = random.Random(trial.seed)
    start_s = time.monotonic()
    moment_s = rng.uniform(0.0, LONGEST_WAIT_S)
    until(lambda: run.process.poll() is not None, moment_s)
    wants_launcher = rng.random() < 0.12
    number = signal.SIGKILL if wants_launcher or rng.random() < 0.5 else signal.SIGSTOP
    if wants_launcher:
        pid, words = run.process.pid, "launcher"
    else:
        if not until(run.processes, RUN_LIMIT_S):
            trial.faults.append(f"no process to hit: {run.said[-300:]}")
            return
        pid, words = rng.choice(sorted(run.processes().items()))
    names = _names_of(words)
    trial.victim, trial.signal_name = names[0], signal.Signals(number).name
    trial.moment_s = time.monotonic() - start_s
    heard = len(run.said)
    os.kill(pid, number)
    hit_s = time.monotonic()
    if not wants_launcher:
        if until(lambda: any(name in run.said[heard:] for name in names), RUN_LIMIT_S):
            trial.named_after_s = time.monotonic() - hit_s
        if trial.named_after_s is None or trial.named_after_s > NAMED_WITHIN_S:
            trial.faults.append(f"named after {trial.named_after_s} s: {run.said[heard:][-400:]}")
    if not until(lambda: run.process.poll() is not None, RUN_LIMIT_S):
        trial.faults.append(f"still running {RUN_LIMIT_S:g} s later: {run.said[heard:][-400:]}")


def _names_of(words: str) -> list[str]:
    """Return the names of a process, the first one for the table."""
    if words == "launcher":
        return ["launcher"]
    if EAR_MODULE in words:
        return [EAR.name]
    if "auv_bag.process" in words:
        return ["auv_bag.process", "recorder_node", "the bag"]
    parts = words.split("--node ")[1:]
    nodes = [part.split()[:2] for part in parts]
    names = [f"{namespace.rstrip('/')}/{module.rsplit('.', 1)[1]}" for module, namespace in nodes]
    if len(names) > 2:
        return ["/node_container", "/clock_node", *names]
    if "/acoustic_relay_node" in names:
        return [*names, "/clock_node"]
    return names + [namespace for _, namespace in nodes if namespace.strip("/")]


def _judge_end(run: HitRun, trial: Trial, before: set[Path]) -> None:
    expected = -signal.SIGKILL if trial.victim == "launcher" else 3
    if trial.status != expected:
        trial.faults.append(f"status {trial.status}, not {expected}: {run.said[-400:]}")
    if not until(lambda: not run.processes(), 5.0):
        trial.faults.append(f"left behind: {run.processes()}")
    if trial.victim == "launcher":  # no process is left to clean up: the next run does
        scenario = run.out.parent / "pair.yaml"
        subprocess.run(
            _command(scenario, "--layout", "single", "--duration", 1, "--out", run.out.parent / "next"),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=RUN_LIMIT_S,
            check=False,
        )
    left = sorted(path.name for path in segments() - before)
    if left:
        trial.faults.append(f"{len(left)} files left in {SHM}: {left[:3]}")


def _judge_results(run: HitRun, trial: Trial) -> None:
    folders = list(run.out.iterdir()) if run.out.is_dir() else []
    if not folders:
        return
    bag = folders[0] / "bag"
    readable = list(bag.glob("*.mcap")) if bag.is_dir() else []
    if not readable:
        return
    report = subprocess.run(
        _command("--report", folders[0]),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=REPORT_LIMIT_S,
        check=False,
    )
    last_words = report.stderr.strip().splitlines()[-1:]
    if report.returncode not in (0, 2) or (report.returncode == 2 and not _is_too_early(last_words)):
        trial.faults.append(f"--report gives status {report.returncode}: {last_words}")
    try:
        with Reader(bag) as reader:
            by_rosbags = sum(1 for _ in reader.messages())
        with readable[0].open("rb") as stream:
            by_mcap = sum(1 for _ in make_reader(stream).iter_messages())
    except Exception as error:
        trial.faults.append(f"the bag cannot be read: {type(error).__name__}: {error}")
        return
    if by_rosbags != by_mcap:
        trial.faults.append(f"rosbags reads {by_rosbags} messages, mcap {by_mcap}")


def _is_too_early(last_words: list[str]) -> bool:
    """Return whether a report was refused since no vehicle had moved yet."""
    return bool(last_words) and "holds no state of" in last_words[0]
