"""
Configuration dataclasses as ROS parameters.

Every field of a configuration becomes one declared, read-only parameter with its type, description and
range; nested configurations and plugin sections become dotted names (``outage.kind``,
``outage.params.loss_prob``), items of a list of configurations too (``heard_reports.n0.report.kind``).  The
values go through the same strict loader as a scenario.
"""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterUninitializedException,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from auv_core.params import ConfigError, Section, dump, item_key, load
from auv_core.plugins import PluginError, find_plugin, list_plugins

T = TypeVar("T")
_TYPES = {
    bool: Parameter.Type.BOOL,
    int: Parameter.Type.INTEGER,
    float: Parameter.Type.DOUBLE,
    str: Parameter.Type.STRING,
}
_ARRAYS = {
    float: Parameter.Type.DOUBLE_ARRAY,
    int: Parameter.Type.INTEGER_ARRAY,
    str: Parameter.Type.STRING_ARRAY,
}
_HUGE = 1e300


def declare_config(node: Node, cls: type[T], prefix: str = "") -> T:
    """
    Declare the parameters of a configuration on `node` and return the configuration that their values make.

    Parameters
    ----------
    node : Node
        The node that owns the parameters.
    cls : type
        Frozen dataclass with fields made by `auv_core.params.param`.
    prefix : str
        Put before every name, with its dot.

    Raises
    ------
    ConfigError
        For a value that is missing, mistyped or not allowed.

    """
    raw = _declare_fields(node, cls, prefix)
    return load(cls, raw, prefix.rstrip(".") or f"parameters of {node.get_name()}")


def refuse_unknown_parameters(nodes: Sequence[Node]) -> None:
    """
    Refuse parameters of a process that none of its nodes has.

    Raises
    ------
    ConfigError
        With the name and the known names.

    """
    for node in nodes:
        for name in node._parameter_overrides:
            if not any(each.has_parameter(name) for each in nodes):
                beside = _names_beside(name, nodes)
                raise ConfigError(
                    f"parameters of {node.get_fully_qualified_name()}: unknown name {name!r}; "
                    f"allowed: {', '.join(beside)}"
                )


def _names_beside(name: str, nodes: Sequence[Node]) -> list[str]:
    """Return the parameters under the longest prefix of a dotted name that has any."""
    known = sorted({known for node in nodes for known in node._parameters})
    while "." in name:
        name = name.rpartition(".")[0]
        beside = [each for each in known if each.startswith(name + ".")]
        if beside:
            return beside
    return [each for each in known if not each.startswith("qos_overrides.")]


def _declare_fields(node: Node, cls: Any, prefix: str) -> dict[str, Any]:
    hints = typing.get_type_hints(cls)
    raw: dict[str, Any] = {}
    for field in dataclasses.fields(cls):
        hint = _without_none(hints[field.name])
        name = prefix + field.name
        value: Any
        if hint is Section:
            value = _declare_section(node, name, field)
        elif dataclasses.is_dataclass(hint):
            value = _declare_fields(node, hint, name + ".")
        elif _is_list_of_configs(hint):
            value = _declare_items(node, name, typing.get_args(hint)[0])
        else:
            value = _declare_value(node, name, hint, field.default, field.metadata)
        if value is not None:
            raw[field.name] = value
    return raw


def _is_list_of_configs(hint: Any) -> bool:
    return typing.get_origin(hint) is tuple and dataclasses.is_dataclass(typing.get_args(hint)[0])


def _declare_items(node: Node, name: str, item: Any) -> list[dict[str, Any]]:
    """Declare a list of configurations; its length follows from the parameters that the node is given."""
    items: list[dict[str, Any]] = []
    while True:
        prefix = f"{name}.{item_key(len(items))}."
        if not any(given.startswith(prefix) for given in node._parameter_overrides):
            return items
        items.append(_declare_fields(node, item, prefix))


def _declare_section(node: Node, name: str, field: dataclasses.Field[Any]) -> dict[str, Any] | None:
    folder = field.metadata["plugins"]
    doc = f"{field.metadata['doc']}; one of: {', '.join(list_plugins(folder))}"
    kind = _declare_value(node, f"{name}.kind", str, dataclasses.MISSING, {"doc": doc})
    if kind is None:
        return None
    try:
        params = find_plugin(folder, kind).Params
    except PluginError as error:
        raise ConfigError(f"{name}.kind: {error}") from None
    return {"kind": kind, "params": _declare_fields(node, params, f"{name}.params.")}


def _declare_value(node: Node, name: str, hint: Any, default: Any, metadata: Mapping[str, Any]) -> Any:
    kind, array = _ros_type(hint)
    descriptor = ParameterDescriptor(
        name=name,
        description=_description(metadata),
        read_only=True,
        additional_constraints=_constraints(metadata),
    )
    if not array:
        _add_range(descriptor, kind, metadata)
    initial = kind if default in (dataclasses.MISSING, None, ()) else dump(default)
    try:
        node.declare_parameter(name, initial, descriptor)
        value = node.get_parameter(name).value
    except ParameterUninitializedException:
        return None
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        raise ConfigError(" ".join(str(error).split())) from None
    return list(value) if array and value is not None else value


def _without_none(hint: Any) -> Any:
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return next(option for option in typing.get_args(hint) if option is not type(None))
    return hint


def _ros_type(hint: Any) -> tuple[Parameter.Type, bool]:
    if typing.get_origin(hint) is tuple:
        return _ARRAYS[typing.get_args(hint)[0]], True
    return _TYPES[hint], False


def _description(metadata: Mapping[str, Any]) -> str:
    return str(metadata.get("doc", ""))


def _constraints(metadata: Mapping[str, Any]) -> str:
    choices = metadata.get("choices")
    if choices:
        return "one of: " + ", ".join(choices)
    return f"greater than {metadata['above']:g}" if metadata.get("above") is not None else ""


def _add_range(descriptor: ParameterDescriptor, kind: Parameter.Type, metadata: Mapping[str, Any]) -> None:
    low, high, above = (metadata.get(key) for key in ("minimum", "maximum", "above"))
    if low is None and high is None and above is None:
        return
    low = above if low is None else low
    if kind is Parameter.Type.DOUBLE:
        span = FloatingPointRange(
            from_value=float(-_HUGE if low is None else low), to_value=float(_HUGE if high is None else high)
        )
        descriptor.floating_point_range = [span]
    elif kind is Parameter.Type.INTEGER:
        limits = (-(2**63) if low is None else int(low), 2**63 - 1 if high is None else int(high))
        descriptor.integer_range = [IntegerRange(from_value=limits[0], to_value=limits[1], step=1)]
