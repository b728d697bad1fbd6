"""The topics of a node, each with its message writer and its required readers."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from auv_ros.qos import EVERY_TICK

RECORDER = "/recorder_node"


class Topic:
    """
    A topic that a node publishes.

    Parameters
    ----------
    node : Node
        Who publishes.
    kind : type
        Of the messages.
    name : str
        Of the topic, in the namespace of the node.
    write : callable, optional
        Returns the message as bytes.
    heard_by : collection of str
        Full names of the nodes that must receive the topic from its first message on.
    qos : QoSProfile
        Offered quality of service.

    Attributes
    ----------
    publish : callable
        Publishes the message that `write` makes of its arguments; without `write`, a message object.
    publish_bytes : callable
        Publishes a serialised message. `Publisher.publish` calls the same function after it has checked the
        type of the message and taken a lock that a single-threaded process does not need.

    """

    def __init__(
        self,
        node: Node,
        kind: Any,
        name: str,
        write: Callable[..., bytes] | None = None,
        *,
        heard_by: Collection[str] = (),
        qos: QoSProfile = EVERY_TICK,
    ) -> None:
        self.publisher: Publisher = node.create_publisher(kind, name, qos)
        self.heard_by = frozenset(heard_by)
        self.publish_bytes: Callable[[bytes], None] = self.publisher.handle.publish_raw
        self.publish: Callable[..., None] = (
            _writes(write, self.publish_bytes) if write else self.publisher.publish
        )


class Topics:
    """
    The topics of one node; a recorder of the run must receive all of them.

    Parameters
    ----------
    node : Node
        Who publishes.
    is_recorded : bool
        Whether the run has a recorder.
    waits : bool
        Whether the node waits for the other nodes of the run, too.

    """

    def __init__(self, node: Node, *, is_recorded: bool = False, waits: bool = True) -> None:
        self._node = node
        self._recorder = frozenset([RECORDER] if is_recorded else ())
        self._waits = waits
        self._topics: list[Topic] = []

    def add(
        self,
        kind: Any,
        name: str,
        write: Callable[..., bytes] | None = None,
        *,
        heard_by: Collection[str] = (),
        qos: QoSProfile = EVERY_TICK,
    ) -> Topic:
        """Return a new topic; `Topic` has the parameters."""
        awaited = self._recorder.union(heard_by if self._waits else ())
        topic = Topic(self._node, kind, name, write, heard_by=awaited, qos=qos)
        self._topics.append(topic)
        return topic

    def __iter__(self) -> Iterator[Topic]:
        return iter(self._topics)


def _writes(write: Callable[..., bytes], publish_bytes: Callable[[bytes], None]) -> Callable[..., None]:
    def publish(*content: Any) -> None:
        publish_bytes(write(*content))

    return publish
