"""
Process that writes the bag of one recorder: ``python -m auv_bag.process FILE_DESCRIPTOR``.

The recorder starts it and communicates with it over this connection (:mod:`auv_bag.link`). It ends on
request after closing the bag, when the connection ends (a killed recorder ends it), or when the bag cannot be
written. It ignores signals that ask for an end; the recorder handles them. So all messages that it received
are in the bag, and the bag has its summary, unless this process itself is killed: then the chunk in progress
is lost, see :mod:`auv_bag.writer`.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import suppress
from multiprocessing.connection import Connection

from auv_bag.definitions import DefinitionError
from auv_bag.link import Batch, Opening, Written
from auv_bag.recorder import BagRecorder
from auv_bag.writer import BagError, BagWriter
from auv_core.machine.whole_files import WriteError


def serve(line: Connection) -> None:
    """Write one bag; answer each message with the content so far, or with a `BagError` as the last answer."""
    opening: Opening = line.recv()
    try:
        for written in _record(line, opening):
            _answer(line, written)
    except (BagError, DefinitionError, WriteError) as error:
        _answer(line, BagError(str(error)))
    except OSError as error:
        _answer(line, BagError(f"cannot write the bag {opening.bag_dir}: {error.strerror}"))


def _record(line: Connection, opening: Opening) -> Iterator[Written]:
    """Write the received batches and close the bag; yield the content after each step."""
    bag = _Bag(opening)
    yield bag.written()
    for batch in _batches(line):
        bag.take(batch)
        yield bag.written()
    bag.close()
    yield bag.written(closed=True)


class _Bag:
    """A bag and the recorder that feeds it."""

    def __init__(self, opening: Opening) -> None:
        self._writer = BagWriter(opening.bag_dir)
        self._recorder = BagRecorder(self._writer, lockstep=opening.lockstep)
        self._sinks = {spec.name: self._recorder.sink(spec) for spec in opening.topics}

    def close(self) -> None:
        """Close the bag, and report messages that are not in it."""
        self._recorder.finish()
        for topic, count in sorted(self._recorder.left_out.items()):
            sys.stderr.write(f"{topic}: {count} messages that do not match its type are not recorded\n")

    def take(self, batch: Batch) -> None:
        """Write a batch."""
        for topic, messages in batch.messages.items():
            self._sinks[topic](messages)
        self._recorder.flush()
        if batch.is_checkpoint:
            self._writer.checkpoint(self._recorder.held())

    def written(self, *, closed: bool = False) -> Written:
        """Return the content of the bag."""
        recorder, writer = self._recorder, self._writer
        return Written(recorder.ticks, recorder.now_ns, writer.message_count, writer.byte_count, closed)


def _batches(line: Connection) -> Iterator[Batch]:
    """Yield messages until the recorder sends the last one or has ended."""
    with suppress(EOFError, OSError):
        yield from iter(line.recv, None)


def _answer(line: Connection, answer: Written | BagError) -> None:
    with suppress(ConnectionError):  # the recorder has ended; the bag is written all the same
        line.send(answer)


def main() -> None:
    """Write a bag for the process at the other end of the connection."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    serve(Connection(int(sys.argv[1])))


if __name__ == "__main__":
    main()
