"""
Subscriptions that no malformed message can end.

The middleware delivers any bytes that a writer sends under a type's name. Here every message comes as bytes;
malformed ones are dropped and counted by topic. Writers that the middleware refused are counted, too, even if
they came and went between two looks at the graph; none of their messages is delivered.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

from rclpy.event_handler import QoSRequestedIncompatibleQoSInfo, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from auv_core.cdr import MalformedError

_REPEAT_S = 10.0


class Hearing:
    """
    The subscriptions of one node.

    Attributes
    ----------
    malformed : Counter
        Number of dropped messages, by topic.
    refused : Counter
        Number of writers refused for their quality of service, by topic.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.malformed: Counter[str] = Counter()
        self.refused: Counter[str] = Counter()

    def listen(
        self, kind: Any, topic: str, take: Callable[[bytes], None], qos: QoSProfile | int
    ) -> Subscription:
        """Subscribe to a topic; `take` gets bytes and raises `MalformedError` if they are no `kind`."""

        def hear(data: bytes) -> None:
            try:
                take(data)
            except MalformedError as error:
                self._leave_out(subscription.topic_name, error)

        def refuse(event: QoSRequestedIncompatibleQoSInfo) -> None:
            self._refuse(subscription.topic_name, event.total_count)

        subscription = self._node.create_subscription(
            kind,
            topic,
            hear,
            qos,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=refuse),
            raw=True,
        )
        return subscription

    def listen_decoded(
        self, kind: Any, topic: str, take: Callable[[Any], None], qos: QoSProfile | int
    ) -> Subscription:
        """Subscribe to a topic with few messages; `take` gets message objects."""
        return self.listen(kind, topic, lambda data: take(decoded(kind, data)), qos)

    def _refuse(self, topic: str, count: int) -> None:
        self.refused[topic] = count
        self._node.get_logger().warning(
            f"{topic}: writers that do not offer what this run asks for are not heard, {count} so far",
            throttle_duration_sec=_REPEAT_S,
        )

    def _leave_out(self, topic: str, error: MalformedError) -> None:
        self.malformed[topic] += 1
        self._node.get_logger().error(
            f"{topic}: {error}: left out, {self.malformed[topic]} so far", throttle_duration_sec=_REPEAT_S
        )


def decoded(kind: Any, data: bytes) -> Any:
    """Return a serialised message as an object; raise `MalformedError` for bytes that are no `kind`."""
    try:
        return deserialize_message(data, kind)
    except Exception as error:  # each layer of the client library has its own exception
        raise MalformedError(f"{len(data)} bytes are not a {kind.__name__}") from error
