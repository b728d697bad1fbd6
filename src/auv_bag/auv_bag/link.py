"""
The recorder's end of the connection to the process that writes its bag.

That process (:mod:`auv_bag.process`) takes batches of raw messages and answers each with the current content
of the bag, or with the error that ended it. The recorder waits only for space in the connection: answers are
read when the next batch is sent. The process is started, not forked, since the recorder has the
middleware's threads. It has its own session, so that no signal to the recorder reaches it: when the recorder
ends, the process sees the end of the connection and closes the bag.
"""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from contextlib import suppress
from multiprocessing.connection import Pipe
from pathlib import Path
from typing import NamedTuple

from auv_bag.topic_spec import TopicSpec
from auv_bag.writer import BagError
from auv_core.machine.child_end import Exit
from auv_core.machine.process_states import is_stopped

BAG_PROCESS_MODULE = "auv_bag.process"
_ANSWER_LIMIT_S = 30.0
_STOPPED_LIMIT_S = 3.0
_LOOK_S = 0.5


class Opening(NamedTuple):
    """
    The first message to the process.

    `bag_dir` is created and must not exist; `topics` are the topics in the order of the bag.
    """

    bag_dir: Path
    topics: tuple[TopicSpec, ...]
    lockstep: bool


class Batch(NamedTuple):
    """
    A batch of messages by topic, in the order of the topics.

    `is_checkpoint` requests an update of the files.
    """

    messages: dict[str, list[bytes]]
    is_checkpoint: bool = False


class Written(NamedTuple):
    """Content of a bag: ticks of /clock, messages and bytes, and the scenario time reached (ns)."""

    ticks: int = 0
    now_ns: int = 0
    messages: int = 0
    bytes: int = 0
    closed: bool = False


class BagLink:
    """
    Starts the process that writes a bag, and communicates with it.

    Parameters
    ----------
    opening
        The first message to the process.

    Attributes
    ----------
    written : Written
        The newest answer.
    """

    def __init__(self, opening: Opening) -> None:
        self._bag_dir = opening.bag_dir
        self._line, far_end = Pipe()
        with far_end:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", BAG_PROCESS_MODULE, str(far_end.fileno())],
                stdin=subprocess.DEVNULL,
                pass_fds=[far_end.fileno()],
                start_new_session=True,
            )
        self.written = Written()
        self._was_stopped = False
        threading.Thread(target=self._end_if_stopped, daemon=True).start()
        self._send(opening)

    def wait_until_open(self) -> None:
        """
        Wait for the first answer.

        Raises
        ------
        BagError
            If the folder already exists or cannot be made, or a message type is not installed.
        """
        self._hear()

    def write(self, batch: Batch) -> None:
        """
        Send a batch and read the answers that have come.

        Raises
        ------
        BagError
            If an earlier batch could not be written, or the process has ended.
        """
        self._send(batch)
        while self._line.poll():
            self._hear()

    def close(self) -> None:
        """
        Wait until all messages are written, the bag is closed and the process has ended.

        Raises
        ------
        BagError
            As for :meth:`write`.
        """
        self._send(None)
        while not self.written.closed:
            self._hear()
        self._process.wait(_ANSWER_LIMIT_S)

    def _end_if_stopped(self) -> None:
        """Kill the process if a signal has stopped it: it would never answer."""
        looks = 0
        while self._process.poll() is None:
            time.sleep(_LOOK_S)
            looks = looks + 1 if is_stopped(self._process.pid) else 0
            if looks * _LOOK_S >= _STOPPED_LIMIT_S:
                self._was_stopped = True
                self._process.kill()
                return

    def _send(self, word: Opening | Batch | None) -> None:
        with suppress(ConnectionError):  # it has ended; its last answer, if any, says why
            self._line.send(word)

    def _hear(self) -> None:
        """Wait for one answer."""
        if not self._line.poll(_ANSWER_LIMIT_S):
            self._process.kill()
            raise BagError(
                f"cannot write the bag {self._bag_dir}: no answer of its process in {_ANSWER_LIMIT_S:g} s"
            )
        try:
            answer = self._line.recv()
        except (EOFError, OSError):
            how = Exit(BAG_PROCESS_MODULE, self._process.wait(_ANSWER_LIMIT_S)).words
            if self._was_stopped:
                how = f"a signal had stopped it for {_STOPPED_LIMIT_S:g} s"
            raise BagError(f"cannot write the bag {self._bag_dir}: its process has ended ({how})") from None
        if isinstance(answer, BagError):
            self._process.wait(_ANSWER_LIMIT_S)
            raise answer
        self.written = answer
