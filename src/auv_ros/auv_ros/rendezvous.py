"""The start of a node: it publishes only once its readers are matched."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable

from rclpy.node import Node
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.topic_endpoint_info import TopicEndpointInfo

from auv_core.words import listed
from auv_ros.steady_timer import SteadyTimer
from auv_ros.strangers import full_name
from auv_ros.topic import Topic

_LOOK_S = 0.02
_STRANGERS_S = 3.0
"""Longest wait for foreign readers, once the run's own readers are matched."""


class Rendezvous:
    """
    Waits until every topic of a node is matched with all required readers, then calls `on_ready` once.

    A reliable writer that has matched a reader delivers everything from then on; so no message of a run is
    lost, however slowly its processes find each other.
    """

    def __init__(self, node: Node, topics: Iterable[Topic], on_ready: Callable[[], None]) -> None:
        self._node = node
        self._waiting = list(topics)
        self._on_ready = on_ready
        self._offers: dict[str, list[TopicEndpointInfo]] = {}
        self._alone_since_s = math.inf
        self.ready = False
        self._timer = SteadyTimer(node, _LOOK_S, self._look)

    def missing(self) -> list[str]:
        """Return the full names of the nodes that are not found or not connected yet, sorted."""
        absent = set().union(*(self._absent(topic) for topic in self._waiting))
        return sorted(absent or set().union(*(topic.heard_by for topic in self._waiting)))

    def waits_for(self) -> str:
        """Return as text which nodes are missing, or which topics are not matched."""
        names = [topic.publisher.topic_name for topic in self._waiting]
        return listed(self.missing()) or listed(names)

    def _look(self) -> None:
        self._waiting = [topic for topic in self._waiting if not self._complete(topic)]
        if not self._waiting and not self.ready:
            self.ready = True
            self._timer.cancel()
            self._on_ready()

    def _complete(self, topic: Topic) -> bool:
        """
        Return whether a topic is matched with all required readers.

        Its publisher knows how many readers it has matched, but not which. So the node also waits for
        foreign readers, for a short time, if they can match at all.
        """
        matched = topic.publisher.get_subscription_count()
        if matched < len(topic.heard_by):
            return False  # without a query of the graph, which is slow in a large fleet
        readers = self._readers(topic)
        if not topic.heard_by <= set(readers):
            self._alone_since_s = math.inf
            return False
        self._alone_since_s = min(self._alone_since_s, time.monotonic())
        if time.monotonic() - self._alone_since_s > _STRANGERS_S:
            readers = [name for name in readers if name in topic.heard_by]
        return matched >= len(readers)

    def _absent(self, topic: Topic) -> set[str]:
        return set(topic.heard_by) - set(self._readers(topic))

    def _readers(self, topic: Topic) -> list[str]:
        """Return the readers that can match: of this type, and with a compatible request."""
        name = topic.publisher.topic_name
        own = self._offered(name)
        return [
            full_name(info)
            for info in self._node.get_subscriptions_info_by_topic(name)
            if all(_can_match(offer, info) for offer in own)
        ]

    def _offered(self, topic: str) -> list[TopicEndpointInfo]:
        """
        Return our offered quality of service from the graph, where the middleware's defaults are filled in.
        """
        if topic not in self._offers:
            own_name = self._node.get_fully_qualified_name()
            infos = self._node.get_publishers_info_by_topic(topic)
            found = [info for info in infos if full_name(info) == own_name]
            if not found:
                return []
            self._offers[topic] = found
        return self._offers[topic]


def _can_match(offer: TopicEndpointInfo, reader: TopicEndpointInfo) -> bool:
    compatible = qos_check_compatible(offer.qos_profile, reader.qos_profile)[0] != QoSCompatibility.ERROR
    return compatible and offer.topic_type == reader.topic_type
