"""Message classes and QoS profiles by the names that bags and the graph use. Imports ROS when called."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from auv_bringup.bag_writer import BagError, Qos

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile


def message_class(type_name: str) -> Any:
    """Return the Python class of a message type.

    Parameters
    ----------
    type_name
        ``package/msg/Type``.

    Raises
    ------
    BagError
        If the package is not installed or has no such message.
    """
    package, _, name = type_name.rpartition("/")
    try:
        return getattr(importlib.import_module(package.replace("/", ".")), name)
    except (ImportError, AttributeError, ValueError):
        raise BagError(f"message type {type_name} is not installed here") from None


def qos_of_profile(profile: QoSProfile) -> Qos:
    """Return an offered profile in rosbag2's words."""
    return Qos(
        history=profile.history.name.lower(),
        depth=profile.depth,
        reliability=profile.reliability.name.lower(),
        durability=profile.durability.name.lower(),
        deadline_ns=profile.deadline.nanoseconds,
        lifespan_ns=profile.lifespan.nanoseconds,
        liveliness=profile.liveliness.name.lower(),
        liveliness_lease_duration_ns=profile.liveliness_lease_duration.nanoseconds,
        avoid_ros_namespace_conventions=bool(profile.avoid_ros_namespace_conventions),
    )


def offer_like_recorded(offered_qos: tuple[Mapping[str, Any], ...]) -> QoSProfile:
    """Return the profile with which to publish a recorded topic again.

    Reliability and durability are those of the first recorded publisher (names, or the numbers of older
    bags); the history keeps everything, so that a reliable reader misses nothing.
    """
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

    recorded = offered_qos[0] if offered_qos else {}
    best_effort = str(recorded.get("reliability")) in ("best_effort", "2")
    latched = str(recorded.get("durability")) in ("transient_local", "1")
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL,
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
