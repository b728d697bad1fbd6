"""
Child processes that never outlive their parent.

Every child leads its own session: Ctrl-C in a terminal reaches only the parent, which then ends its
children. If the parent is killed, the kernel kills the children (PR_SET_PDEATHSIG, Linux). This module does
not use ROS.
"""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from auv_core.machine.child_end import Exit
from auv_core.machine.child_start import ForkedChild, child_setup, run_forked
from auv_core.machine.process_states import adopt_orphans, family_of, is_stopped, module_of, orphans

SIGINT_GRACE_S = 6.0
SIGTERM_GRACE_S = 2.0
HURRY_GRACE_S = 1.0
_WAIT_SLICE_S = 0.05
_LOOK_S = 0.02
_KILL_TIMEOUT_S = 10.0


class ChildProcesses:
    """
    The children of this process, by name.

    A context manager: on exit it kills all children that still run, and processes that ended children have
    left running.

    Attributes
    ----------
    returncodes : dict
        Return code of each child whose end was noticed, by name.

    """

    def __init__(self) -> None:
        self._running: dict[str, subprocess.Popen[bytes] | ForkedChild] = {}
        self._logs: dict[str, Path] = {}
        self._of_others: frozenset[int] = frozenset()
        self.returncodes: dict[str, int] = {}

    def start(
        self,
        name: str,
        arguments: Sequence[str],
        *,
        log: Path,
        environ: Mapping[str, str],
        pass_fds: Sequence[int] = (),
    ) -> None:
        """Start a child whose output goes to the file `log`, and that keeps some file descriptors."""
        with log.open("ab") as output:
            self._running[name] = subprocess.Popen(
                list(arguments),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env=dict(environ),
                pass_fds=pass_fds,
                start_new_session=True,
                preexec_fn=child_setup(os.getpid()),
            )
        self._logs[name] = log

    def fork(self, name: str, run: Callable[[], int], *, log: Path) -> None:
        """
        Start a child that has already imported the modules of this process; `run` returns its exit status.

        This process must have no threads that could hold a lock, see `child_start.threads_allow_fork`.
        """
        process = ForkedChild(target=run_forked, args=(run, os.getpid(), log), name=name)
        process.start()
        self._running[name] = process
        self._logs[name] = log

    @property
    def running(self) -> list[str]:
        """Names of the children whose end was not noticed yet."""
        return list(self._running)

    def pid(self, name: str) -> int:
        """Return the process id of a running child."""
        return self._running[name].pid

    def log(self, name: str) -> Path:
        """Return the log of a child, running or not."""
        return self._logs[name]

    def collect_exits(self) -> list[Exit]:
        """Return the children that have ended since the last call, each once."""
        exits = []
        for name, process in list(self._running.items()):
            returncode = process.poll()
            if returncode is not None:
                exits.append(self._ended(name, returncode))
        return exits

    def end(
        self,
        names: Iterable[str],
        *,
        grace_s: float = SIGINT_GRACE_S,
        sigterm_after_s: float | None = None,
        is_hurried: Callable[[], bool] = lambda: False,
    ) -> list[Exit]:
        """
        End children: SIGINT, after a grace SIGTERM, after another SIGKILL.

        Parameters
        ----------
        names : iterable of str
            Children; those that have already ended are skipped.
        grace_s : float
            Time between SIGINT and SIGTERM (s).
        sigterm_after_s : float, optional
            Send SIGTERM this long after SIGINT (s), and SIGKILL `grace_s` later: for children that stop
            waiting for others at SIGTERM.
        is_hurried : callable
            Called repeatedly; once it returns True the graces shrink to `HURRY_GRACE_S`.

        Returns
        -------
        exits : list of Exit
            One per child that was still running.

        """
        wanted = [name for name in names if name in self._running]
        exits: list[Exit] = []
        self._kill_stopped(wanted)
        sigint_s, sigterm_s = grace_s, SIGTERM_GRACE_S
        if sigterm_after_s is not None:
            sigint_s, sigterm_s = sigterm_after_s, grace_s
        for number, patience_s in ((signal.SIGINT, sigint_s), (signal.SIGTERM, sigterm_s)):
            self._signal(wanted, number)
            exits += self._wait(wanted, patience_s, is_hurried)
        return exits + self.kill(wanted)

    def kill(self, names: Iterable[str]) -> list[Exit]:
        """End children at once."""
        wanted = [name for name in names if name in self._running]
        self._signal(wanted, signal.SIGKILL)
        return self._wait(wanted, _KILL_TIMEOUT_S, lambda: False)

    def stopped(self) -> dict[str, str]:
        """
        Return the running children that are stopped by a signal or have started a stopped process: by name
        the stopped process, '' for the child itself.
        """
        found = {}
        for name, process in self._running.items():
            for member in family_of(process.pid) if process.pid is not None else ():
                if is_stopped(member):
                    found[name] = "" if member == process.pid else module_of(member)
                    break
        return found

    def end_orphans(self, *, grace_s: float, is_hurried: Callable[[], bool] = lambda: False) -> list[int]:
        """
        Wait for processes that ended children have left running; kill those that take longer or are stopped.

        Parameters
        ----------
        grace_s : float
            How long to wait (s).
        is_hurried : callable
            Called repeatedly; once it returns True the wait shrinks to `HURRY_GRACE_S`.

        Returns
        -------
        killed : list of int
            Ids of the killed processes.

        """
        start_s = time.monotonic()
        killed: list[int] = []
        while left := self._orphans():
            patience_s = HURRY_GRACE_S if is_hurried() else grace_s
            is_late = time.monotonic() - start_s >= patience_s
            for pid in left:
                if pid not in killed and (is_late or is_stopped(pid)):
                    os.kill(pid, signal.SIGKILL)
                    killed.append(pid)
            if time.monotonic() - start_s > patience_s + _KILL_TIMEOUT_S:
                break
            time.sleep(_LOOK_S)
        return killed

    def __enter__(self) -> ChildProcesses:
        self._of_others = frozenset(orphans())
        adopt_orphans()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.kill(self.running)
        self.end_orphans(grace_s=0.0)

    def _orphans(self) -> list[int]:
        """Reap the orphans that have ended; return those that have not."""
        known = self._of_others.union(process.pid for process in self._running.values())
        left = []
        for pid in orphans():
            if pid not in known and os.waitpid(pid, os.WNOHANG)[0] == 0:
                left.append(pid)
        return left

    def _kill_stopped(self, names: Iterable[str]) -> None:
        """Kill the stopped processes of some children: they react to no other signal."""
        for name in names:
            pid = self._running[name].pid
            for member in list(family_of(pid)) if pid is not None else ():
                if is_stopped(member):
                    with suppress(ProcessLookupError):
                        os.kill(member, signal.SIGKILL)

    def _signal(self, names: Iterable[str], number: signal.Signals) -> None:
        for name in names:
            process = self._running.get(name)
            # A child that was not reaped keeps its process id, so the group cannot belong to another process.
            if process is not None and process.poll() is None and process.pid is not None:
                _signal_group(process.pid, number)

    def _wait(self, names: Iterable[str], grace_s: float, is_hurried: Callable[[], bool]) -> list[Exit]:
        """Wait for the children to end, at most `grace_s`; return those that ended."""
        exits = []
        start_s = time.monotonic()
        for name in names:
            process = self._running.get(name)
            while process is not None:
                left_s = start_s + grace_s - time.monotonic()
                if is_hurried():
                    left_s = min(left_s, start_s + HURRY_GRACE_S - time.monotonic())
                try:
                    returncode = process.wait(timeout=min(max(left_s, 0.0), _WAIT_SLICE_S))
                except subprocess.TimeoutExpired:
                    if left_s <= 0.0:
                        break
                    continue
                exits.append(self._ended(name, returncode))
                break
        return exits

    def _ended(self, name: str, returncode: int) -> Exit:
        del self._running[name]
        self.returncodes[name] = returncode
        return Exit(name, returncode)


def _signal_group(pid: int, number: signal.Signals) -> None:
    """Signal a child and the processes that it has started; a fork without a session is signalled alone."""
    try:
        os.killpg(pid, number)
    except ProcessLookupError:
        os.kill(pid, number)
