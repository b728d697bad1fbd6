"""Give each received message its time and put it into the bag: the recorder without ROS.

The time of a message in the bag is scenario time, never the wall clock's, so that two lock-step runs make the
same bag:

* a message with a stamp (its header, or that of its first element) has the stamp's time;
* one without (an empty list of markers, a log line stamped by the wall clock) has that of the newest /clock,
  or of the newest stamp where there is no /clock;
* latched messages with stamp 0 or of a type without one, and all without a stamp that come before the first
  message with one, have the time of that first message.

Padding is zeroed, see :mod:`auv_bringup.cdr_padding`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import itemgetter

from auv_bringup.bag_writer import BagWriter, Qos, Topic
from auv_bringup.cdr_padding import padding_zeroer
from auv_bringup.message_definitions import MessageType, load_message_type, read_stamp_ns, stamp_offset
from auv_bringup.recorded_topics import CLOCK_TOPIC, TopicSpec


class BagRecorder:
    """Feeds a :class:`BagWriter` from the topics of a graph.

    Parameters
    ----------
    writer
        The bag, empty.
    offered_qos
        Returns the QoS that the publishers of a topic offer; asked when its first message comes.
    describe
        Returns what a bag says of a message type, by its name.
    """

    def __init__(
        self,
        writer: BagWriter,
        offered_qos: Callable[[str], tuple[Qos, ...]],
        describe: Callable[[str], MessageType] = load_message_type,
    ) -> None:
        self._writer = writer
        self._offered_qos = offered_qos
        self._describe = describe
        self._first_ns: int | None = None
        self._now_ns = 0
        self._untimed: list[tuple[int, bytes]] = []
        self._taken: list[tuple[int, int, bytes]] = []
        self.ticks = 0
        """Number of /clock messages taken."""

    @property
    def now_ns(self) -> int:
        """Scenario time reached: that of the newest /clock, or of the newest stamp without one (ns)."""
        return self._now_ns

    def sink(self, spec: TopicSpec) -> Callable[[Sequence[bytes]], None]:
        """Return the function that takes messages of one topic, in the order in which they were published.

        The topic enters the bag with its first message.

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
        channel = 0

        def take(messages: Sequence[bytes]) -> None:
            nonlocal channel
            if messages and not channel:
                qos = self._offered_qos(spec.name) or (_usual_qos(spec),)
                channel = self._writer.add_topic(Topic(spec.name, message_type, qos))
            for data in map(zeroed, messages):
                stamp_ns = None if offset is None else read_stamp_ns(data, offset)
                if stamp_ns is None or (stamp_ns == 0 and spec.latched):
                    self._take_untimed(channel, data, at_start=stands or stamp_ns == 0)
                else:
                    self._take_timed(channel, data, max(stamp_ns, 0))

        def take_clock(messages: Sequence[bytes]) -> None:
            take(messages)
            if messages:
                self.ticks += len(messages)
                self._now_ns = self._taken[-1][0]

        return take_clock if spec.name == CLOCK_TOPIC else take

    def flush(self) -> None:
        """
        Write what was taken since the last call, in order of time.

        Messages may be taken topic by topic, many at once; in the bag those of one time stand together.
        """
        taken, self._taken = self._taken, []
        taken.sort(key=itemgetter(0))
        write = self._writer.write
        for time_ns, channel, data in taken:
            write(channel, data, time_ns)

    def finish(self) -> None:
        """Write all that was taken, also what still waits for a first stamp, and close the bag."""
        self._release_untimed(0)
        self.flush()
        self._writer.close()

    def _take_timed(self, channel: int, data: bytes, time_ns: int) -> None:
        """Take a message with a stamp of its own."""
        if self._first_ns is None:
            self._release_untimed(time_ns)
        self._taken.append((time_ns, channel, data))
        if time_ns > self._now_ns and self.ticks == 0:
            self._now_ns = time_ns

    def _take_untimed(self, channel: int, data: bytes, *, at_start: bool) -> None:
        """Take a message without a time, or keep it until there is one."""
        if self._first_ns is None:
            self._untimed.append((channel, data))
        else:
            self._taken.append((self._first_ns if at_start else self._now_ns, channel, data))

    def _release_untimed(self, first_ns: int) -> None:
        """Write the messages that came before the first stamp."""
        self._first_ns = first_ns
        for channel, data in self._untimed:
            self._taken.append((first_ns, channel, data))
        self._untimed.clear()


def _usual_qos(spec: TopicSpec) -> Qos:
    """Return what a topic's publishers should offer, for one whose publisher has gone already."""
    return Qos(durability="transient_local" if spec.latched else "volatile")
