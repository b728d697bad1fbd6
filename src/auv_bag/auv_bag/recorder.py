"""The recorder without ROS: it gives each received message its time and its place in the bag.

The time of a message in the bag is the run's, never the wall clock's:

* a message with a stamp (its header, or that of its first element) has the stamp's time if that is on the
  run's time line (:mod:`auv_bag.time_line`), and otherwise the newest time of the run;
* a message without a stamp (an empty list of markers, a log line stamped by the wall clock) has the newest
  time of the run;
* latched messages with stamp 0 or of a type without a stamp, and all messages without a stamp that come
  before the run's time is known, have the time of tick 0.

Messages of one time are in the order of topics, and those of topics with several publishers in the order of
their bytes. In lock-step they are held back until all messages of that time have surely arrived, so that
equal runs make equal bags. Repeated messages of a latched topic, and the status of a run that has not
started, are left out; for /flock/status they depend on the wall clock. Padding is zeroed, see
:mod:`auv_bag.padding`.
"""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Callable, Sequence

from auv_bag.definitions import MessageType, load_message_type, read_stamp_ns, stamp_offset
from auv_bag.file import TimedMessage
from auv_bag.padding import padding_zeroer
from auv_bag.time_line import TimeLine
from auv_bag.topic_spec import TopicSpec
from auv_bag.topics import CLOCK_TOPIC, STATUS_TOPIC
from auv_bag.writer import BagWriter, Qos, Topic

HELD_TICKS = 200
"""Number of ticks of lock-step that are held back; no message in transit is later than that."""
FIRST_HELD_TICKS = 1000
"""The same at the start, when the middleware may have to send a first message again 0.4 s later."""
HELD_BYTES, LEAST_HELD_TICKS = 64_000_000, 20
"""
Above this number of bytes only this number of ticks is held back, as for large fleets, whose ticks take long.
"""
_AT_BEGIN = -1


class BagRecorder:
    """Feeds a :class:`BagWriter` from the topics of a graph.

    Parameters
    ----------
    writer
        The bag, empty.
    lockstep
        Whether the time of the run comes from /clock, or from /flock/status, as in real time.
    describe
        Returns a bag's data about a message type, by its name.
    """

    def __init__(
        self,
        writer: BagWriter,
        *,
        lockstep: bool,
        describe: Callable[[str], MessageType] = load_message_type,
    ) -> None:
        self._writer = writer
        self._lockstep = lockstep
        self._describe = describe
        self._line = TimeLine()
        self._held: defaultdict[int, list[tuple[int, bytes, bytes]]] = defaultdict(list)
        self._held_bytes = 0
        self._newest_ticks: deque[int] = deque(maxlen=FIRST_HELD_TICKS)
        self.ticks = 0
        """Number of /clock messages taken."""
        self.left_out: Counter[str] = Counter()
        """Number of messages that do not match their topic's type, by topic."""

    @property
    def now_ns(self) -> int:
        """The run's time: that of the newest /clock, in real time that of the newest status (ns)."""
        return self._line.now_ns

    def sink(self, spec: TopicSpec) -> Callable[[Sequence[bytes]], None]:
        """Return the function that takes messages of one topic, in the order in which they were published.

        The topic is added to the bag now, so that the order of topics is that of the calls of this method.

        Raises
        ------
        DefinitionError
            If the message type is not installed.
        """
        message_type = self._describe(spec.type_name)
        place = stamp_offset(message_type.definition)
        offset = place if spec.stamped else None
        stands = spec.latched and place is None
        zeroed = padding_zeroer(message_type)
        channel = self._writer.add_topic(Topic(spec.name, message_type, (_offered_qos(spec),)))
        tell = self._teller(spec.name)
        said = b""

        def take(messages: Sequence[bytes]) -> None:
            nonlocal said
            for message in messages:
                data = zeroed(message)
                if data is None:
                    self.left_out[spec.name] += 1
                    continue
                stamp_ns = None if offset is None else read_stamp_ns(data, offset)
                is_again = spec.latched and data == said
                if is_again or (stamp_ns == 0 and spec.name == STATUS_TOPIC):
                    continue
                said = data
                if stamp_ns is not None and tell is not None:
                    tell(stamp_ns)
                key = data if spec.shared else b""
                time_ns = self._time_ns(stamp_ns, stands=stands or (stamp_ns == 0 and spec.latched))
                self._held[time_ns].append((channel, key, data))
                self._held_bytes += len(data)

        return take

    def flush(self) -> None:
        """Write complete ticks, in order: all in real time, and in lock-step all but the newest ones."""
        if not self._lockstep:
            self._write(None)
            return
        # After the start two ticks are released for each new one, so that no process waits for the writer.
        held_ticks = max(HELD_TICKS, 2 * FIRST_HELD_TICKS - self.ticks)
        if len(self._newest_ticks) >= held_ticks:
            self._write(self._newest_ticks[-held_ticks])
        if self._held_bytes > HELD_BYTES and len(self._newest_ticks) > LEAST_HELD_TICKS:
            self._write(self._newest_ticks[-LEAST_HELD_TICKS])

    def held(self) -> list[TimedMessage]:
        """Return the messages that are not written yet, in order."""
        self._settle()
        return [
            TimedMessage(time_ns, channel, data)
            for time_ns in sorted(self._held)
            for channel, _, data in sorted(self._held[time_ns], key=_place)
        ]

    def finish(self) -> None:
        """Write all messages and close the bag."""
        self._write(None)
        self._writer.close()

    def _teller(self, topic: str) -> Callable[[int], None] | None:
        """Return the function that reads the run's time from a topic's messages, if the topic has it."""
        if topic == CLOCK_TOPIC and self._lockstep:
            return self._tell_tick
        return self._line.tell if topic == STATUS_TOPIC and not self._lockstep else None

    def _tell_tick(self, stamp_ns: int) -> None:
        self.ticks += 1
        self._line.tell_tick(stamp_ns)
        self._newest_ticks.append(self._line.now_ns)

    def _time_ns(self, stamp_ns: int | None, *, stands: bool) -> int:
        """Return the time of a message (ns), or `_AT_BEGIN`."""
        if stands:
            return _AT_BEGIN
        if stamp_ns is not None:
            return self._line.place(max(stamp_ns, 0))
        return _AT_BEGIN if self._line.begin_ns is None else self._line.now_ns

    def _write(self, before_ns: int | None) -> None:
        """Write the messages before a time, or all of them."""
        self._settle()
        write = self._writer.write
        for time_ns in sorted(self._held):
            if before_ns is not None and time_ns >= before_ns:
                return
            for channel, _, data in sorted(self._held.pop(time_ns), key=_place):
                write(channel, data, time_ns)
                self._held_bytes -= len(data)

    def _settle(self) -> None:
        """
        Set the time of messages at the start: that of the first stamp, if no topic gives the run's time.
        """
        if _AT_BEGIN in self._held:
            begin_ns = self._line.begin_ns
            if begin_ns is None:
                begin_ns = min((time_ns for time_ns in self._held if time_ns >= 0), default=0)
            self._held[begin_ns] += self._held.pop(_AT_BEGIN)


def _place(message: tuple[int, bytes, bytes]) -> tuple[int, bytes]:
    """Sort key of the messages of one time."""
    channel, key, _ = message
    return channel, key


def _offered_qos(spec: TopicSpec) -> Qos:
    """
    Return the QoS that a replay of a topic must offer.

    It is the QoS of the run's nodes except for the liveliness, which distinguishes the run's own writers.
    """
    if spec.latched:
        return Qos(history="keep_last", depth=1, durability="transient_local")
    return Qos(history="keep_last", depth=1000)
