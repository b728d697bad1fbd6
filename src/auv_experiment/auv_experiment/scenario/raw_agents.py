"""
Agents as raw data, before they are loaded: what a vehicle's own section takes from the common one, and the
parts of a flock that a scenario leaves out.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

import auv_control.controllers
from auv_core.plugins import PluginError
from auv_flocking.agent_config import PARTS

_EITHER_OR = (("course", "fleet"), ("fleet", "course"))
_TASKS = {"fleet", *(name for names in PARTS.values() for name in names)}

_FLOCK_WITHOUT_MODEM: dict[str, Any] = {
    "flocking": {"kind": "potential"},
    "separation": {"kind": "mathematical"},
    "consensus": {"kind": "thesis"},
}
_FLOCK_ON_A_MODEM: dict[str, Any] = {
    "flocking": {"kind": "communication_aware"},
    "separation": {"kind": "mathematical"},
    "consensus": {"kind": "neighbour_mean"},
    "neighbours": {
        "timeout_s": 900.0,
        "acceleration_memory_s": 60.0,
        "velocity_memory_s": 15.0,
    },
    "hold_s": 60.0,
}


def completed(own: Mapping[str, Any], common: Any) -> dict[str, Any]:
    """
    Return a vehicle's own agent with what it leaves out taken from the common one.

    A part of the task that the own controller does not use, such as the flocking law of a torpedo among
    vehicles that flock, is not taken; nor is the fleet of a vehicle with a course of its own, or the reverse.
    """
    if not isinstance(common, Mapping):
        return dict(own)
    unused = _TASKS - _used(merged(common.get("controller"), own.get("controller", {})))
    unused |= {other for one, other in _EITHER_OR if own.get(one) is not None}
    taken = {key: value for key, value in common.items() if key not in unused}
    whole: dict[str, Any] = merged(taken, own)
    return whole


def _used(controller: Any) -> set[str]:
    """Return the parts of a task that a controller uses; all of them if there is no such controller."""
    follows = _follows(controller)
    if follows is None:
        return _TASKS
    return {*PARTS.get(follows, ()), *(("fleet",) if follows == "course" else ())}


def with_flock(agent: Mapping[str, Any], modem: Any) -> dict[str, Any]:
    """
    Return an agent with the missing parts of a flock filled in.

    On the ideal modem these are the thesis's parts. On every other modem they are `communication_aware` and
    the parts that suit it.
    """
    if (
        "flocking" in agent
        or not isinstance(modem, Mapping)
        or _follows(agent.get("controller")) != "velocity"
    ):
        return dict(agent)
    parts = _FLOCK_WITHOUT_MODEM if modem.get("kind") == "ideal" else _FLOCK_ON_A_MODEM
    whole = {**copy.deepcopy(parts), **agent}
    if isinstance(agent.get("neighbours"), Mapping):
        whole["neighbours"] = {**parts.get("neighbours", {}), **agent["neighbours"]}
    return whole


def merged(preset: Any, explicit: Any) -> Any:
    """
    Return a section: explicit keys override those of the preset, also within its mappings, unless they name
    another kind.
    """
    if not isinstance(preset, Mapping) or not isinstance(explicit, Mapping):
        return explicit
    if "kind" in explicit and explicit["kind"] != preset.get("kind"):
        return explicit
    return {**preset, **{key: merged(preset.get(key), value) for key, value in explicit.items()}}


def _follows(controller: Any) -> str | None:
    """Return what a raw controller follows, None if there is no such controller."""
    try:
        follows: str = auv_control.controllers.controller_class(controller["kind"]).follows
    except (KeyError, TypeError, PluginError):
        return None
    return follows
