"""Foreign programs that publish on topics of a run in real time: named in the log, reported once a second."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from rclpy.node import Node

from auv_ros.steady_timer import SteadyTimer
from auv_ros.strangers import StrangerWatch
from auv_ros.topic import RECORDER
from auv_sim.nodes.link_reports import LinkReports

_PERIOD_S = 1.0
_COMMON_NODES = frozenset({"/acoustic_relay_node", "/clock_node", RECORDER})


class StrangerReport:
    """
    Finds foreign publishers for the relay, once a second after `begin`.

    Parameters
    ----------
    node : Node
        The relay.
    reports : LinkReports
        Publishes the findings.
    refused : mapping
        Writers that the middleware did not connect so far, by topic.
    own_nodes : iterable of str
        Full names of the nodes of the vehicles.
    vehicle_ids : sequence of str
        Names of the vehicles.
    are_admitted : bool
        Whether foreign publishers are accepted.

    """

    def __init__(
        self,
        node: Node,
        reports: LinkReports,
        refused: Mapping[str, int],
        *,
        own_nodes: Iterable[str],
        vehicle_ids: Sequence[str],
        are_admitted: bool,
    ) -> None:
        self._node = node
        self._reports = reports
        self._refused = refused
        self._are_admitted = are_admitted
        own = _COMMON_NODES.union(own_nodes)
        self._watch = StrangerWatch(node, own, vehicle_ids, admits_strangers=are_admitted)

    def begin(self, stamp_s: Callable[[], float | None]) -> None:
        """Start to look; `stamp_s` returns the stamp of a report (s), None if no report is due."""
        SteadyTimer(self._node, _PERIOD_S, lambda: self._look(stamp_s()))

    def _look(self, t_s: float | None) -> None:
        if t_s is None:
            return
        for stranger in self._watch.look():
            self._node.get_logger().warning(stranger.words)
        found = self._watch.found.values()
        self._reports.tell_strangers(found, self._refused, t_s, are_admitted=self._are_admitted)
