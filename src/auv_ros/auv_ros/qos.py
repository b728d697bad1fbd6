"""
Quality of service of a run's topics: what its nodes offer each other, and what keeps strangers out.

Own writers offer, and own readers request, the liveliness MANUAL_BY_TOPIC, with an endless lease, so that
nobody renews it.  Tools and other people's nodes offer AUTOMATIC, which is less than that: the middleware
never connects their writers with our readers, no message of theirs gets in, and no message costs more for it.
Their readers request AUTOMATIC, which is less than we offer: they hear the run.

Own writers keep their last `OWN_DEPTH` messages.  A stranger's reader that stalls then misses messages and
holds up nobody; a writer that keeps everything waits for it.  Own readers miss nothing: in lock-step the
recorder, the slowest of them, is at most 200 ticks and one batch of 20 behind, and a writer sends one message
per topic and tick.  The rest of the depth is for messages that the transport lost: the middleware sends them
again within 0.4 s (two heartbeats, see fastdds.xml), in which the quickest flight measured makes 600 ticks.
"""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

OWN_DEPTH = 1000


def own_qos(
    *, latched: bool = False, history: HistoryPolicy = HistoryPolicy.KEEP_LAST, admits_strangers: bool = False
) -> QoSProfile:
    """
    Return the profile of a reader or writer of the run.

    Parameters
    ----------
    latched : bool
        Whether a reader that comes later gets the last message.
    history : HistoryPolicy
        KEEP_ALL is for readers only: see above.
    admits_strangers : bool
        Whether a reader also hears writers that are not the run's own.

    """
    return QoSProfile(
        depth=1 if latched else OWN_DEPTH,
        history=history,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        liveliness=LivelinessPolicy.AUTOMATIC if admits_strangers else LivelinessPolicy.MANUAL_BY_TOPIC,
    )


EVERY_TICK = own_qos()
LATCHED = own_qos(latched=True)
EVERY_LATCHED = own_qos(latched=True, history=HistoryPolicy.KEEP_ALL)
"""For readers of a latched topic that must miss nothing: else one writer's message displaces another's."""
