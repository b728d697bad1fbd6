"""Where a run is, who has fallen silent, and how it ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from auv_core.params import param

WAITING, RUNNING, STALLED = "waiting", "running", "stalled"
FINISHED, ABORTED = "finished", "aborted"
LOST_STATUS = 3
"""Exit status of the process of a run that a loss has ended."""
RECORDER_LEAD_TICKS = 200
"""So far lock-step may be ahead of its recorder."""
STATUS_TICKS = 20


@dataclass(frozen=True, kw_only=True)
class WatchConfig:
    """Length of the run, and how long silence is borne."""

    duration_ticks: int = param("length of the run (control periods)", minimum=1)
    on_vehicle_loss: str = param("when a vehicle falls silent", default="stop", choices=("stop", "continue"))
    answer_timeout_s: float = param(
        "silence after which a node counts as lost (s, wall)", default=3.0, above=0.0
    )
    start_timeout_s: float = param("the same before the first tick (s, wall)", default=60.0, above=0.0)
    launched: bool = param("whether a launcher must hear the status before the first tick", default=False)


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
        When the wait for the first tick begins.

    Attributes
    ----------
    state, detail : str
        As in auv_msgs/FlockStatus.
    tick : int
        The tick that was begun last.
    lost : list of str
        Ids of the vehicles that the run goes on without.
    exit_code : int
        Of the process, once the run is `done`.

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
        """Whether the run has come to its end, good or bad."""
        return self.state in (FINISHED, ABORTED)

    @property
    def has_room(self) -> bool:
        """Whether the recorder is near enough for another tick; only lock-step could outrun it."""
        lead = self.tick - self._recorded_ticks
        return not self._recorder or not self._lockstep or lead <= RECORDER_LEAD_TICKS

    @property
    def limit_s(self) -> float:
        """Silence after which a node counts as lost (s)."""
        return self._watch.answer_timeout_s if self._has_started else self._watch.start_timeout_s

    def begin_tick(self, tick: int, now_s: float) -> bool:
        """Begin a tick; the last one ends the run. Return whether there is something to tell."""
        is_news = self.state != RUNNING or tick % STATUS_TICKS == 0
        self.tick, self._moved_at_s = tick, now_s
        if tick >= self._watch.duration_ticks:
            self._end(FINISHED, "")
        elif is_news:
            self.state = RUNNING
        return is_news or self.done

    def hear_recorder(self, ticks: int, now_s: float) -> bool:
        """Take how many ticks are recorded; return whether there is room again."""
        had_room = self.has_room
        self._recorder_heard_at_s, self._recorded_ticks = now_s, ticks
        return self.has_room and not had_room

    def silent(self, awaited: Callable[[], list[str]]) -> list[str]:
        """Return the full names of the nodes that owe an answer, `awaited` those of the vehicles."""
        return awaited() if self.has_room else [self._recorder]

    def overdue(self, awaited: Callable[[], list[str]], now_s: float) -> list[str]:
        """Return the full names of the nodes that have been silent for too long."""
        if now_s - self._recorder_heard_at_s > self.limit_s:
            return [self._recorder]
        if (self._lockstep or not self._has_started) and now_s - self._moved_at_s < self.limit_s:
            return []
        return self.silent(awaited) or ([] if self._has_started else ["/acoustic_relay_node"])

    def stall(self, names: Sequence[str]) -> str:
        """Note that nodes are overdue; return it in words."""
        words = f"{', '.join(names)}: no answer for tick {self.tick} within {self.limit_s:g} s"
        self.state, self.detail = STALLED, words
        return words

    def goes_on_without(self, names: Sequence[str]) -> bool:
        """Return whether the run goes on without nodes that are overdue; where it does not, end it."""
        if self._recorder in names or not self._has_started or self._watch.on_vehicle_loss == "stop":
            self._end(ABORTED, self.detail)
        return not self.done

    def lose(self, vehicle_ids: Sequence[str], fleet_size: int, now_s: float) -> None:
        """Go on without vehicles, as long as there are others in a fleet of this size."""
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
