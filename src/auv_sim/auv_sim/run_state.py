"""The state of a run: its tick, silent nodes, and its end."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from auv_core.params import param

WAITING, RUNNING, STALLED = "waiting", "running", "stalled"
FINISHED, ABORTED = "finished", "aborted"
LOST_STATUS = 3
"""Exit status of a run's process after a loss."""
RECORDER_LEAD_TICKS = 200
"""Number of ticks that lock-step may be ahead of its recorder."""
STATUS_TICKS = 20


@dataclass(frozen=True, kw_only=True)
class WatchConfig:
    """Length of the run, and limits of silence."""

    duration_ticks: int = param("length of the run (control periods)", minimum=1)
    on_vehicle_loss: str = param(
        "what to do if a vehicle falls silent", default="stop", choices=("stop", "continue")
    )
    answer_timeout_s: float = param(
        "silence after which a node counts as lost (s, wall)", default=3.0, above=0.0
    )
    start_timeout_s: float = param("the same before the first tick (s, wall)", default=60.0, above=0.0)
    launched: bool = param("whether a launcher must receive the status before the first tick", default=False)


class RunState:
    """
    The state of one run; every `now_s` is a time of one steady clock (s).

    Parameters
    ----------
    watch : WatchConfig
        Length of the run and time-outs.
    lockstep : bool
        Whether ticks wait for answers.
    recorder : str
        Full name of the node that records, '' for none.
    now_s : float
        Time at which the wait for the first tick begins.

    Attributes
    ----------
    state, detail : str
        As in auv_msgs/FlockStatus.
    tick : int
        The current tick.
    lost : list of str
        Ids of the lost vehicles.
    exit_code : int
        Exit status of the process, once the run is `done`.

    """

    def __init__(self, watch: WatchConfig, *, lockstep: bool, recorder: str, now_s: float) -> None:
        self._watch = watch
        self._lockstep = lockstep
        self._recorder = recorder
        self._recorded_ticks = 0
        self._recorder_heard_at_s = math.inf
        self._moved_at_s = now_s
        self.state, self.detail = WAITING, ""
        self.tick = 0
        self.lost: list[str] = []
        self.exit_code = 0

    @property
    def done(self) -> bool:
        """Whether the run has ended, in success or failure."""
        return self.state in (FINISHED, ABORTED)

    @property
    def has_room(self) -> bool:
        """Whether the recorder keeps up; only lock-step could be too fast for it."""
        lead = self.tick - self._recorded_ticks
        return not self._recorder or not self._lockstep or lead <= RECORDER_LEAD_TICKS

    @property
    def limit_s(self) -> float:
        """Silence after which a node counts as lost (s)."""
        return self._watch.answer_timeout_s if self._has_started else self._watch.start_timeout_s

    def begin_tick(self, tick: int, now_s: float) -> bool:
        """Begin a tick; the last one ends the run. Return whether a status is due."""
        is_news = self.state != RUNNING or tick % STATUS_TICKS == 0
        self.tick, self._moved_at_s = tick, now_s
        if tick >= self._watch.duration_ticks:
            self._end(FINISHED, "")
        elif is_news:
            self.state = RUNNING
        return is_news or self.done

    def hear_recorder(self, ticks: int, now_s: float) -> bool:
        """Note the number of recorded ticks; return whether the recorder has caught up."""
        had_room = self.has_room
        self._recorder_heard_at_s, self._recorded_ticks = now_s, ticks
        return self.has_room and not had_room

    def silent(self, awaited: Callable[[], list[str]]) -> list[str]:
        """Return the full names of the nodes that have not answered; `awaited` are those of the vehicles."""
        return awaited() if self.has_room else [self._recorder]

    def overdue(self, awaited: Callable[[], list[str]], now_s: float) -> list[str]:
        """Return the full names of the nodes that have been silent for too long."""
        if now_s - self._recorder_heard_at_s > self.limit_s:
            return [self._recorder]
        if (self._lockstep or not self._has_started) and now_s - self._moved_at_s < self.limit_s:
            return []
        return self.silent(awaited) or ([] if self._has_started else ["/acoustic_relay_node"])

    def stall(self, names: Sequence[str]) -> str:
        """Note that nodes are overdue; return a line about it."""
        words = f"{', '.join(names)}: no answer for tick {self.tick} within {self.limit_s:g} s"
        self.state, self.detail = STALLED, words
        return words

    def goes_on_without(self, names: Sequence[str]) -> bool:
        """Return whether the run continues without overdue nodes; if not, end it."""
        if self._recorder in names or not self._has_started or self._watch.on_vehicle_loss == "stop":
            self._end(ABORTED, self.detail)
        return not self.done

    def lose(self, vehicle_ids: Sequence[str], fleet_size: int, now_s: float) -> None:
        """Continue without vehicles, as long as a fleet of this size has others."""
        self.state, self._moved_at_s = RUNNING, now_s
        self.lost += vehicle_ids
        if len(self.lost) == fleet_size:
            self._end(ABORTED, "every vehicle is lost")

    @property
    def _has_started(self) -> bool:
        return self.tick > 0

    def _end(self, state: str, detail: str) -> None:
        self.state, self.detail = state, detail
        self.exit_code = LOST_STATUS if state == ABORTED else 0
