"""Takes the messages of a run in batches; without ROS."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from auv_bag.link import Batch
from auv_bag.topics import CLOCK_TOPIC

TICKS_PER_BATCH = 20


class Collector:
    """
    Takes all waiting messages, topic by topic.

    Parameters
    ----------
    waiting : mapping of str to callable
        By topic, in the order of the bag: the function that takes and returns its waiting messages.

    Attributes
    ----------
    topics_met : set of str
        The topics that have had messages.

    """

    def __init__(self, waiting: Mapping[str, Callable[[], list[bytes]]]) -> None:
        self._waiting = waiting
        self._heard_ticks: list[bytes] = []
        self.topics_met: set[str] = set()

    def hear_tick(self, tick: bytes) -> bool:
        """Keep a message of /clock that no longer waits; return whether a batch is due."""
        self._heard_ticks.append(tick)
        return len(self._heard_ticks) >= TICKS_PER_BATCH

    def batch(self, *, is_checkpoint: bool = False) -> Batch:
        """Take all messages."""
        batch = Batch({}, is_checkpoint)
        for topic, take in self._waiting.items():
            messages = take()
            if topic == CLOCK_TOPIC:
                messages, self._heard_ticks = self._heard_ticks + messages, []
            if messages:
                batch.messages[topic] = messages
                self.topics_met.add(topic)
        return batch
