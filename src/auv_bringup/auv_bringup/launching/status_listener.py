"""
The launcher's view of a run: a separate process, the ear, listens for it.

A call of the middleware can block forever: after a step of the system clock, or if it shares memory with a
killed process. So the launcher makes no such call. An ear that is blocked reports nothing, and is killed at
the end.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from functools import partial
from importlib import import_module
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from setproctitle import setproctitle

from auv_bringup.launching.flight_status import Status
from auv_bringup.launching.layout import ProcessSpec
from auv_core.machine.child_start import threads_allow_fork
from auv_core.machine.processes import ChildProcesses
from auv_ros.run_config import LAUNCHER_NODE

CLOCK_NODE = "/clock_node"
"""It runs in the process of the relay."""
EAR = ProcessSpec(LAUNCHER_NODE, (), "launcher", "")
EAR_MODULE = "auv_bringup.nodes.launcher_ear"
LOOK = "look"
"""Asks the ear for foreign publishers; it answers with the next `News` that is an answer."""
_WAKE_S = 0.1
_ANSWER_S = 1.0
_LEAVE_S = 1.0


class Opening(NamedTuple):
    """The first message to the ear: the environment of the nodes, and the nodes of the run."""

    environ: dict[str, str]
    own_nodes: frozenset[str]
    vehicle_ids: tuple[str, ...]


class News(NamedTuple):
    """What the ear has received since its last message; refused writers are counted from the start."""

    statuses: tuple[Status, ...] = ()
    strangers: tuple[str, ...] = ()
    refused: tuple[str, ...] = ()
    is_answer: bool = False


class StatusListener:
    """
    Starts the ear and takes its news; ends it on exit.

    Parameters
    ----------
    children : ChildProcesses
        Gets the ear, as `EAR`.
    environ : dict
        Environment of the nodes.
    processes : sequence of ProcessSpec
        Processes of the run.
    log : Path
        Log of the ear.

    Attributes
    ----------
    strangers : list of str
        Foreign publishers on topics of the run so far, one line each.
    refused_writers : tuple of str
        Number of refused writers, including unnamed ones, one line for each subscribed topic.

    """

    def __init__(
        self,
        children: ChildProcesses,
        environ: dict[str, str],
        processes: Sequence[ProcessSpec],
        log: Path,
    ) -> None:
        self._children = children
        nodes = [node for process in processes for node in process.nodes]
        self._opening = Opening(
            environ,
            frozenset({node.name for node in nodes} | {CLOCK_NODE}),
            tuple(sorted({node.vehicle_id for node in nodes if node.vehicle_id})),
        )
        self._log = log
        self._heard: list[Status] = []
        self._new_strangers: list[str] = []
        self._is_gone = False
        self.strangers: list[str] = []
        self.refused_writers: tuple[str, ...] = ()

    def __enter__(self) -> StatusListener:
        self._line, far_end = Pipe()
        with far_end:
            if threads_allow_fork():
                self._children.fork(EAR.name, partial(_be_the_ear, self._line, far_end), log=self._log)
            else:
                number = far_end.fileno()
                words = [sys.executable, "-P", "-m", EAR_MODULE, str(number)]
                self._children.start(
                    EAR.name, words, log=self._log, environ=self._opening.environ, pass_fds=[number]
                )
        self._send(self._opening)
        return self

    def listen(self) -> list[Status]:
        """Wait for a status, at most `_WAKE_S`; return the received ones, oldest first."""
        if self._is_gone:
            time.sleep(_WAKE_S)
        else:
            self._take(_WAKE_S)
        heard, self._heard = self._heard, []
        return heard

    def new_strangers(self, *, at_once: bool = False) -> list[str]:
        """
        Return a line for each new foreign publisher on topics of the run.

        The graph is queried once a second, or `at_once`.
        """
        if at_once:
            self._look()
        words, self._new_strangers = self._new_strangers, []
        self.strangers += words
        return words

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._line.close()
        self._children.end([EAR.name], grace_s=_LEAVE_S)

    def _look(self) -> None:
        self._send(LOOK)
        deadline_s = time.monotonic() + _ANSWER_S
        while not self._is_gone and time.monotonic() < deadline_s and not self._take(_WAKE_S):
            pass

    def _send(self, word: Opening | str) -> None:
        try:
            self._line.send(word)
        except OSError:
            self._is_gone = True

    def _take(self, patience_s: float) -> bool:
        """Take the news that come within a time (s); return whether one of them is an answer."""
        has_answer = False
        try:
            while self._line.poll(patience_s):
                news: News = self._line.recv()
                self._heard += news.statuses
                self._new_strangers += news.strangers
                self.refused_writers = news.refused
                has_answer |= news.is_answer
                patience_s = 0.0
        except (EOFError, OSError):
            self._is_gone = True
        return has_answer


def _be_the_ear(near_end: Connection, line: Connection) -> int:
    """Run as the ear, as a fork of the launcher."""
    near_end.close()
    setproctitle(f"{sys.executable} -P -m {EAR_MODULE} {line.fileno()}")
    return int(import_module(EAR_MODULE).serve(line))
