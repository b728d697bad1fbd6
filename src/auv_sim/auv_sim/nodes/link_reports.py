"""The relay's topics for observers: counters of the acoustic links, diagnostics and markers."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from visualization_msgs.msg import Marker, MarkerArray

from auv_core.geometry import Vec3
from auv_core.messages import Inbox, VehicleState
from auv_msgs.msg import AcousticStats
from auv_ros.strangers import Stranger
from auv_ros.topic import Topics
from auv_ros.wire.acoustics import stats_bytes
from auv_ros.wire.diagnostics import Status, diagnostics_bytes
from auv_ros.wire.markers import LINK, MARKER_TICKS, LineList, lines
from auv_sim.acoustics.links import DELAY_EDGES_S, LinkCounters
from auv_sim.relay.state_watch import StateWatch

_NAMESPACE, _NUMBER = "acoustic links", 0


class LinkReports:
    """Publishes the outcomes of packets; `topics` are those of the relay, to which these are added."""

    def __init__(self, topics: Topics) -> None:
        self._stats = topics.add(AcousticStats, "/acoustic/stats", stats_bytes)
        self._diagnostics = topics.add(DiagnosticArray, "/diagnostics", diagnostics_bytes)
        self._markers = topics.add(MarkerArray, "/markers", LineList(_NAMESPACE, _NUMBER, LINK).filled)
        self._links: list[tuple[int, int, int]] = []

    def count(self, counters: Mapping[tuple[int, int], LinkCounters], t_s: float) -> None:
        """Publish the counters of all links, and their summary, at the time `t_s` (s)."""
        links = sorted(counters.items())
        numbers = [((*ends, *link.numbers()), link.delay_counts) for ends, link in links]
        self._stats.publish(DELAY_EDGES_S, numbers, t_s)
        sent, delivered = sum(link.sent for _, link in links), sum(link.delivered for _, link in links)
        ratio = delivered / sent if sent else math.nan
        status = Status(
            level=DiagnosticStatus.WARN if sent and not delivered else DiagnosticStatus.OK,
            name="acoustic_relay_node: links",
            message=f"{delivered} of {sent} receptions" if sent else "nothing sent yet",
            hardware_id="acoustic medium",
            values=[("delivery_ratio", f"{ratio:.4f}")],
        )
        self._diagnostics.publish([status], t_s)

    def tell_states(self, stale: str, watch: StateWatch, t_s: float) -> None:
        """Publish which vehicles' states are too old to locate the modem, at the time `t_s` (s)."""
        status = Status(
            level=DiagnosticStatus.ERROR if stale else DiagnosticStatus.OK,
            name="acoustic_relay_node: states",
            message=f"modems silent: {stale}" if stale else "all fresh",
            hardware_id="acoustic medium",
            values=[
                ("packets_unsent", str(watch.packets_unsent)),
                ("states_left_out", str(watch.left_out)),
                ("last_left_out", watch.left_out_words),
            ],
        )
        self._diagnostics.publish([status], t_s)

    def tell_strangers(
        self, strangers: Collection[Stranger], refused: Mapping[str, int], t_s: float, *, are_admitted: bool
    ) -> None:
        """
        Publish the foreign publishers on topics of the run, at the time `t_s` (s).

        `refused` counts, by subscribed topic, the writers that the middleware did not connect.
        """
        is_odd = refused or (strangers and not are_admitted)
        level = DiagnosticStatus.WARN if is_odd else DiagnosticStatus.OK
        if not are_admitted and any(stranger.is_heard for stranger in strangers):
            level = DiagnosticStatus.ERROR
        unnamed = "writers came and went, and were refused" if refused else "no foreign publishers"
        status = Status(
            level=level,
            name="acoustic_relay_node: strangers",
            message="; ".join(stranger.words for stranger in strangers) or unnamed,
            hardware_id="acoustic medium",
            values=[
                *((stranger.topic, f"{stranger.node} {stranger.gid}") for stranger in strangers),
                *((f"writers_refused {topic}", str(count)) for topic, count in sorted(refused.items())),
            ],
        )
        self._diagnostics.publish([status], t_s)

    def note(self, index: int, inbox: Inbox) -> None:
        """Note which vehicles the one at an index has heard."""
        for reception in inbox.receptions:
            self._links.append((inbox.tick, reception.packet.source - 1, index))

    def draw(self, tick: int, t_s: float, states: Sequence[VehicleState], others: Sequence[Marker]) -> None:
        """Publish the recent links between vehicles in these states, and other markers."""
        self._links = [link for link in self._links if link[0] > tick - 2 * MARKER_TICKS]
        ends: list[Vec3] = []
        for _, source, destination in self._links:
            ends += (states[source].position, states[destination].position)
        if others:
            links = lines(_NAMESPACE, _NUMBER, t_s, ends, LINK, joined=False)
            self._markers.publisher.publish(MarkerArray(markers=[links, *others]))
        else:
            self._markers.publish(t_s, ends)
