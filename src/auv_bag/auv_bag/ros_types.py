"""Message classes and QoS profiles by the names that bags and the graph use. Imports ROS when called."""

from __future__ import annotations

import importlib
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from auv_bag.writer import BagError
from auv_core.params import shown

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile

_MESSAGE_TYPE = re.compile(r"(?P<package>[a-z][a-z0-9_]*)/msg/(?P<name>[A-Z][A-Za-z0-9]*)")
_DEPTH = 1000
_LATCHED_DEPTH = 100


def message_class(type_name: str) -> Any:
    """
    Return the Python class of a message type.

    Only interfaces in the ament index are imported: a name from a file or a foreign process never selects a
    module to run.

    Parameters
    ----------
    type_name
        ``package/msg/Type``.

    Raises
    ------
    BagError
        If the package is not installed or has no such message.
    """
    from ament_index_python import get_resource

    found = _MESSAGE_TYPE.fullmatch(type_name)
    try:
        if (
            found
            and f"msg/{found['name']}.idl" in get_resource("rosidl_interfaces", found["package"])[0].split()
        ):
            return getattr(importlib.import_module(f"{found['package']}.msg"), found["name"])
    except (LookupError, OSError, ImportError, AttributeError):
        pass
    raise BagError(f"message type {shown(type_name)} is not installed here")


def is_latched(offered_qos: tuple[Mapping[str, Any], ...]) -> bool:
    """Return whether a recorded topic was published transient local (by name, or number in older bags)."""
    return bool(offered_qos) and str(offered_qos[0].get("durability")) in ("transient_local", "1")


def offer_like_recorded(offered_qos: tuple[Mapping[str, Any], ...]) -> QoSProfile:
    """Return the profile with which to publish a recorded topic again.

    Reliability and durability are those of the first recorded publisher. The history is long but finite, so
    that a stopped reader does not stop the replay. One publisher replaces all recorded ones, so a latched
    topic keeps more than its last message.
    """
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

    latched = is_latched(offered_qos)
    best_effort = bool(offered_qos) and str(offered_qos[0].get("reliability")) in ("best_effort", "2")
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=_LATCHED_DEPTH if latched else _DEPTH,
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
