"""
The YAML of scenarios and studies: strict, with decimal numbers, and bounded in size and time.

Numbers are decimal: ``010`` is ten, ``-.5`` is minus a half. Other notations of YAML 1.1, such as ``10:00``
in base 60, ``0x1f``, ``1_000`` and dates, are read as text, and the schema refuses them as numbers.
"""

from __future__ import annotations

import copy
import re
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from auv_core.params import ConfigError

MOST_BYTES = 1_000_000
MOST_VALUES = 50_000
"""
Largest size of a text and largest number of values; a value counts as often as aliases (``*name``) repeat it.
"""

_INT_TAG, _FLOAT_TAG, _DATE_TAG = (f"tag:yaml.org,2002:{name}" for name in ("int", "float", "timestamp"))
_INT = re.compile(r"[-+]?[0-9]+\Z")
_FLOAT = re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?\Z")
_NOT_FINITE = {
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
_NOT_FINITE_WORD = re.compile("(" + "|".join(map(re.escape, _NOT_FINITE)) + r")\Z")

# What PyYAML's constructors raise on an explicit tag that does not fit its value, such as `!!int ""`.
_MISFIT = (ValueError, TypeError, LookupError, AttributeError, OverflowError)


class _TooManyValuesError(Exception):
    """Raised for more than `MOST_VALUES` values."""


_UNICODE_BREAKS = "\x85\u2028\u2029"


class _Loader(yaml.SafeLoader):
    """YAML without duplicate keys, and with decimal numbers only."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._values = 0

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Return the next value, unless there are too many already."""
        self._values += 1
        if self._values > MOST_VALUES:
            raise _TooManyValuesError
        node: yaml.Node | None = super().compose_node(parent, index)
        return node

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        pairs = node.value if isinstance(node, yaml.MappingNode) else []
        seen: set[str] = set()
        for key, _ in pairs:
            if not isinstance(key, yaml.ScalarNode):
                continue
            if key.value in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key {key.value!r} is given twice", node.start_mark
                )
            seen.add(key.value)
        return super().construct_mapping(node, deep)

    def construct_int(self, node: yaml.ScalarNode) -> int:
        """Return a whole number."""
        if not _INT.match(node.value):
            raise ValueError("not a decimal number")
        return int(node.value)

    def construct_float(self, node: yaml.ScalarNode) -> float:
        """Return a number."""
        if node.value in _NOT_FINITE:
            return _NOT_FINITE[node.value]
        if not _FLOAT.match(node.value):
            raise ValueError("not a decimal number")
        return float(node.value)


class _Dumper(yaml.SafeDumper):
    """Quotes words that `_Loader`, or another reader of YAML, would read as numbers, and line breaks."""

    def represent_str(self, data: str) -> yaml.ScalarNode:
        """
        Return a text in double quotes if it has Unicode line breaks; otherwise they would be read as spaces.
        """
        style = '"' if any(each in data for each in _UNICODE_BREAKS) else None
        return self.represent_scalar("tag:yaml.org,2002:str", data, style)


_Dumper.add_representer(str, _Dumper.represent_str)
_Loader.yaml_implicit_resolvers = {
    first: [(tag, word) for tag, word in resolvers if tag not in (_INT_TAG, _FLOAT_TAG, _DATE_TAG)]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_constructor(_INT_TAG, _Loader.construct_int)
_Loader.add_constructor(_FLOAT_TAG, _Loader.construct_float)
for _yaml in (_Loader, _Dumper):
    for _tag, _word in ((_INT_TAG, _INT), (_FLOAT_TAG, _FLOAT), (_FLOAT_TAG, _NOT_FINITE_WORD)):
        _yaml.add_implicit_resolver(_tag, _word, list("-+.0123456789"))


def to_yaml(plain: Any) -> str:
    """Return plain data as YAML that `parse_yaml` reads back unchanged."""
    text: str = yaml.dump(
        plain, Dumper=_Dumper, sort_keys=False, allow_unicode=True, default_flow_style=None, width=120
    )
    return text


def read_text(path: Path, what: str) -> str:
    """
    Return the text of a file, which may be a pipe.

    Raises
    ------
    ConfigError
        If the file cannot be read, is longer than `MOST_BYTES`, or is not UTF-8; `what` begins the line.

    """
    try:
        with path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "not the path of a file"
        raise ConfigError(
            f"{what}: {str(path)!r} cannot be read ({reason}); allowed: a readable YAML file"
        ) from None
    if len(content) > MOST_BYTES:
        raise ConfigError(
            f"{what}: {str(path)!r} is too long; allowed: a YAML file of at most {MOST_BYTES:,} bytes"
        )
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        raise ConfigError(
            f"{what}: {str(path)!r} cannot be read (not UTF-8 text); allowed: a readable YAML file"
        ) from None


def parse_yaml(text: str, where: str) -> Any:
    """
    Return the content of a text as plain data; the caller may change it.

    Raises
    ------
    ConfigError
        If the text is not YAML, has a key twice, or has more than `MOST_VALUES` values; `where` begins the
        line.

    """
    return copy.deepcopy(_parsed(text, where))  # many runs share the same presets and overrides


@lru_cache(maxsize=128)
def _parsed(text: str, where: str) -> Any:
    try:
        loader = _Loader(text)
        try:
            root = loader.get_single_node()
            if root is None:
                return None
            _count_values(root, {})
            return loader.construct_document(root)
        finally:
            loader.dispose()
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 0
        problem = " ".join(str(error.problem).split())
        raise ConfigError(f"{where}: not YAML: {problem} (line {line})") from None
    except yaml.YAMLError as error:
        raise ConfigError(f"{where}: not YAML: {' '.join(str(error).split())}") from None
    except RecursionError:
        raise ConfigError(f"{where}: nested too deeply; allowed: YAML with fewer levels") from None
    except _TooManyValuesError:
        raise ConfigError(
            f"{where}: too large; allowed: at most {MOST_VALUES:,} values, including those that aliases "
            "repeat"
        ) from None
    except _MISFIT:
        raise ConfigError(f"{where}: not YAML: a value that does not fit its type") from None


def _count_values(node: yaml.Node, known: dict[int, int]) -> int:
    """
    Return the number of values in a node, with aliases expanded.

    `known` has the counts of the nodes so far. A node that is being counted has more than the allowed
    number, so that an alias inside itself is refused.
    """
    if id(node) in known:
        return known[id(node)]
    known[id(node)] = MOST_VALUES
    count = 1
    if isinstance(node, yaml.CollectionNode):
        for child in node.value:
            count += sum(
                _count_values(each, known) for each in (child if isinstance(child, tuple) else (child,))
            )
            if count > MOST_VALUES:
                raise _TooManyValuesError
    known[id(node)] = count
    return count
