"""
Quality of service of a run's topics: it connects the run's nodes and excludes foreign publishers.

Own writers offer, and own readers request, the liveliness MANUAL_BY_TOPIC, with an infinite lease, so that
no renewal is needed. Tools and foreign nodes offer AUTOMATIC, which is less: the middleware never connects
their writers with our readers, so their messages are not delivered, at no cost per message. Their readers
request AUTOMATIC, which is less than we offer, so they hear the run.

Own writers keep their last `OWN_DEPTH` messages. A foreign reader that stalls then misses messages and
blocks no node; a writer that keeps all messages would wait for it. Own readers miss no message: in lock-step
the recorder, the slowest of them, is at most 200 ticks and one batch of 20 behind, and a writer sends one
message per topic and tick. The rest of the depth is for messages that the transport lost: the middleware
sends them again within 0.4 s (two heartbeats, see fastdds.xml), in which the fastest measured flight makes
600 ticks.
"""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

OWN_DEPTH = 1000


def own_qos(
    *,
    latched: bool = False,
    depth: int | None = None,
    history: HistoryPolicy = HistoryPolicy.KEEP_LAST,
    admits_strangers: bool = False,
) -> QoSProfile:
    """
    Return the profile of a reader or writer of the run.

    Parameters
    ----------
    latched : bool
        Whether a reader that comes later gets the last message, or as many as both sides keep.
    depth : int, optional
        Number of messages kept; by default 1 if latched, else `OWN_DEPTH`.
    history : HistoryPolicy
        KEEP_ALL is for readers only: see above.
    admits_strangers : bool
        Whether a reader also hears writers that are not the run's own.

    """
    return QoSProfile(
        depth=depth or (1 if latched else OWN_DEPTH),
        history=history,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        liveliness=LivelinessPolicy.AUTOMATIC if admits_strangers else LivelinessPolicy.MANUAL_BY_TOPIC,
    )


EVERY_TICK = own_qos()
LATCHED = own_qos(latched=True)
LATCHED_SERIES = own_qos(latched=True, depth=OWN_DEPTH)
"""
For a writer of a latched topic whose messages change: the middleware sends a lost message again only while
the writer keeps it.
"""
EVERY_MESSAGE = own_qos(history=HistoryPolicy.KEEP_ALL)
"""
For readers that must miss no message from now on, and want no earlier one: with a depth of 1, one writer's
message replaces another's.
"""
EVERY_LATCHED = own_qos(latched=True, history=HistoryPolicy.KEEP_ALL)
"""The same for readers that also want the earlier messages."""
