"""
Foreign programs that publish on the topics of a run.

The middleware does not deliver their messages (`auv_ros.qos`); this module reports that they exist, with
their data in the graph. It costs nothing per message: it counts the writers of each topic, and queries their
names only if the count has changed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

from rclpy.node import Node
from rclpy.qos import LivelinessPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

RUN_TOPICS = ("/clock", "/flock/status", "/recorder/status", "/acoustic/stats", "/acoustic/events")
"""
Topics that only the run may publish, besides those of its vehicles; on /tf, /markers and others any node may
publish.
"""
_NAMELESS_LOOKS = 5
_UNKNOWN = "_NODE_NAME_UNKNOWN_"


class Stranger(NamedTuple):
    """A foreign writer: its node, topic and gid, and whether readers of the run hear it."""

    node: str
    topic: str
    gid: str
    is_heard: bool

    @property
    def words(self) -> str:
        """Description in one line."""
        return f"{self.node} publishes {self.topic}: {'heard' if self.is_heard else 'not heard'}"


def full_name(info: TopicEndpointInfo) -> str:
    """Return the full name of the node behind an endpoint."""
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"


class StrangerWatch:
    """
    Finds foreign writers for a node.

    Parameters
    ----------
    node : Node
        The node whose view of the graph is used.
    own_nodes : iterable of str
        Full names of the nodes of the run.
    vehicle_ids : iterable of str
        Namespaces of the vehicles, without the slash.
    admits_strangers : bool
        Whether readers of the run hear all publishers.

    Attributes
    ----------
    found : dict
        All foreign writers found so far, by gid; they stay here after they have left.

    """

    def __init__(
        self,
        node: Node,
        own_nodes: Iterable[str],
        vehicle_ids: Iterable[str],
        *,
        admits_strangers: bool = False,
    ) -> None:
        self._node = node
        self._own = frozenset(own_nodes)
        self._prefixes = tuple(f"/{name}/" for name in vehicle_ids)
        self._admits_strangers = admits_strangers
        self._counts: dict[str, int] = {}
        self._nameless: Counter[str] = Counter()
        self.found: dict[str, Stranger] = {}

    def look(self) -> list[Stranger]:
        """Return the foreign writers that are new since the last call."""
        new = []
        for topic, _ in self._node.get_topic_names_and_types():
            if topic.startswith(self._prefixes) or topic in RUN_TOPICS:
                new += self._look_at(topic)
        self.found.update((stranger.gid, stranger) for stranger in new)
        return new

    def _look_at(self, topic: str) -> list[Stranger]:
        count = self._node.count_publishers(topic)
        if count == self._counts.get(topic):
            return []
        infos = self._node.get_publishers_info_by_topic(topic)
        gids = {_gid(info) for info in infos if info.node_name == _UNKNOWN}
        self._nameless.update(gids)
        waited_for = {gid for gid in gids if self._nameless[gid] < _NAMELESS_LOOKS}
        if not waited_for:
            self._counts[topic] = count
        own_like = Counter(full_name(info) for info in infos if _is_offered_as_own(info))
        strangers = [
            self._stranger(info, topic)
            for info in infos
            if _gid(info) not in waited_for and self._is_strange(info, own_like[full_name(info)])
        ]
        return [stranger for stranger in strangers if stranger.gid not in self.found]

    def _is_strange(self, info: TopicEndpointInfo, namesakes: int) -> bool:
        return not _is_offered_as_own(info) or full_name(info) not in self._own or namesakes > 1

    def _stranger(self, info: TopicEndpointInfo, topic: str) -> Stranger:
        name = full_name(info)
        if info.node_name == _UNKNOWN:
            name = "a node without a name"
        elif name in self._own:
            name = f"another {name}" if not _is_offered_as_own(info) else f"one of two {name}"
        return Stranger(name, topic, _gid(info), self._admits_strangers or _is_offered_as_own(info))


def _is_offered_as_own(info: TopicEndpointInfo) -> bool:
    """Return whether a writer's quality of service matches the readers of a run."""
    return info.qos_profile.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC


def _gid(info: TopicEndpointInfo) -> str:
    return bytes(info.endpoint_gid).hex().rstrip("0")
