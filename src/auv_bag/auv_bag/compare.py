"""Compare two bags: are they the same run?"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

from auv_bag.bag import Bag
from auv_bag.topics import SHARED_TOPICS

WALL_CLOCK_TOPICS = frozenset({"/rosout", "/recorder/status"})
"""Topics whose content depends on the wall clock: never part of a comparison."""


def compare_bags(first: Path, second: Path) -> list[str]:
    """Return the differences of two bags, one line each; an empty list means that they are the same run.

    Every topic must hold the same message bytes in the same order. If a topic has several publishers,
    messages of one tick are sorted by their bytes first (each names its source), since they reach the
    recorder in random order. Topics with wall-clock times are left out.
    """
    content_a, content_b = _content(Bag(first)), _content(Bag(second))
    differences = []
    for topic in sorted(content_a.keys() | content_b.keys()):
        messages_a, messages_b = content_a.get(topic, []), content_b.get(topic, [])
        if len(messages_a) != len(messages_b):
            differences.append(f"{topic}: {len(messages_a)} messages against {len(messages_b)}")
        pairs = enumerate(zip(messages_a, messages_b, strict=False))
        unequal = next(((k, a, b) for k, (a, b) in pairs if a[1] != b[1]), None)
        if unequal is not None:
            differences.append(_describe_difference(topic, *unequal))
    return differences


def _content(bag: Bag) -> dict[str, list[tuple[int, bytes]]]:
    """Return time and bytes of each message by topic, in comparable order."""
    topics = bag.topics.keys() - WALL_CLOCK_TOPICS
    content: dict[str, list[tuple[int, bytes]]] = defaultdict(list)
    for message in bag.messages(topics):
        content[message.topic].append((message.time_ns, message.data))
    for topic in content.keys() & SHARED_TOPICS:
        content[topic].sort()
    return content


def _describe_difference(topic: str, index: int, a: tuple[int, bytes], b: tuple[int, bytes]) -> str:
    """Return a line with the first difference of two messages."""
    (time_ns, data_a), (_, data_b) = a, b
    pairs = enumerate(zip(data_a, data_b, strict=False))
    byte = next((k for k, (x, y) in pairs if x != y), min(len(data_a), len(data_b)))
    return (
        f"{topic}: message {index} at {time_ns * 1e-9:.3f} s differs from byte {byte} on "
        f"({len(data_a)} bytes against {len(data_b)})"
    )
