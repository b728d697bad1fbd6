"""
The equations of the thesis: the function that implements each, its test, and any difference from the print.

`docs/reference/equations.yaml` lists every numbered equation of chapters 2 to 6 exactly once, as implemented
or with the reason why not. `problems` compares the list with the source: its functions can be imported, its
tests exist, and each equation that a library docstring cites is listed for that library module.
"""

from __future__ import annotations

import ast
import importlib
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from auv_thesis.items import ChapterError

EQUATIONS_FILE = "docs/reference/equations.yaml"
LIBRARIES = ("auv_core", "auv_control", "auv_flocking")

_NUMBERS = re.compile(r"(\d+)\.(\d+)(?:-(\d+)\.(\d+))?\Z")
_CITED = re.compile(r"\((\d+)\.(\d+)\)(?:\s*-\s*\((\d+)\.(\d+)\))?")
_IMPLEMENTED_KEYS = {"equations", "what", "functions", "tests", "deviation"}
_LEFT_OUT_KEYS = {"equations", "what", "why"}

# within this many characters after the textbook's name, an equation is the textbook's
_NEAR = 60

Number = tuple[int, int]


@dataclass(frozen=True)
class Entry:
    """
    An entry of the list: one or more equations.

    `equations` is as written ("2.6-2.7, 3.7-3.8"). Either there are functions ("module:name") and tests
    ("path::name"), with any difference from the print in `deviation`; or `why` says why there are none.
    """

    equations: str
    what: str
    functions: tuple[str, ...] = ()
    tests: tuple[str, ...] = ()
    deviation: str = ""
    why: str = ""

    @property
    def numbers(self) -> tuple[Number, ...]:
        """The equations one by one, as (chapter, number)."""
        return numbers_in(self.equations)


@dataclass(frozen=True)
class EquationList:
    """The whole list, and how many numbered equations each chapter has."""

    counts: dict[int, int]
    implemented: tuple[Entry, ...]
    left_out: tuple[Entry, ...]


def load_equations(root: Path) -> EquationList:
    """Read the list of a checkout; raise ChapterError, with one line, if it is malformed."""
    path = root / EQUATIONS_FILE
    try:
        raw = yaml.safe_load(path.read_text(encoding="utf-8"))
        return EquationList(
            {int(chapter): int(count) for chapter, count in raw["chapters"].items()},
            tuple(_entry(item, _IMPLEMENTED_KEYS) for item in raw["implemented"]),
            tuple(_entry(item, _LEFT_OUT_KEYS) for item in raw["left_out"]),
        )
    except (OSError, yaml.YAMLError, KeyError, TypeError, AttributeError, ValueError) as error:
        raise ChapterError(f"{EQUATIONS_FILE}: {' '.join(str(error).split())}") from None


def numbers_in(text: str) -> tuple[Number, ...]:
    """Return the numbers in a text like "2.6-2.7, 3.7"; raise ValueError for any other text."""
    found: list[Number] = []
    for part in text.split(","):
        match = _NUMBERS.match(part.strip())
        if match is None:
            raise ValueError(f"{part.strip()!r} is not allowed; allowed: numbers and ranges like 2.6-2.7")
        found += _range(match)
    return tuple(found)


def problems(listed: EquationList, root: Path) -> list[str]:
    """Return each mismatch between the list and the source, as one line."""
    return [
        *_wrong_numbers(listed),
        *_missing_functions(listed),
        *_missing_tests(listed, root),
        *_citations_elsewhere(listed, root),
    ]


def _entry(item: dict[str, Any], keys: set[str]) -> Entry:
    unknown, missing = set(item) - keys, keys - {"deviation"} - set(item)
    name = item.get("equations", "an entry without equations")
    if not isinstance(name, str):
        raise ValueError(f"{name}: equations are text, in quotes (3.10 is not 3.1)")
    if unknown or missing:
        raise ValueError(f"{name}: unknown keys {sorted(unknown)}, missing keys {sorted(missing)}")
    entry = Entry(
        _line(item, "equations"),
        _line(item, "what"),
        tuple(item.get("functions", ())),
        tuple(item.get("tests", ())),
        _line(item, "deviation"),
        _line(item, "why"),
    )
    if not entry.numbers:
        raise ValueError(f"{name}: no numbers")
    return entry


def _line(item: dict[str, Any], key: str) -> str:
    return " ".join(str(item.get(key, "")).split())


def _range(match: re.Match[str]) -> Iterator[Number]:
    chapter, first, last_chapter, last = (int(text) if text else None for text in match.groups())
    if chapter is None or first is None:
        return
    if last is None:
        last_chapter, last = chapter, first
    if last_chapter != chapter or last < first:
        raise ValueError(f"{match.group(0)!r} is not a range within a chapter")
    yield from ((chapter, number) for number in range(first, last + 1))


def _wrong_numbers(listed: EquationList) -> Iterator[str]:
    counted = Counter(number for entry in (*listed.implemented, *listed.left_out) for number in entry.numbers)
    wanted = {(chapter, n) for chapter, count in listed.counts.items() for n in range(1, count + 1)}
    for number in sorted(wanted - set(counted)):
        yield f"{_shown(number)} is not listed"
    for number in sorted(set(counted) - wanted):
        yield f"{_shown(number)} is listed, but the thesis has no such equation"
    for number, count in sorted(counted.items()):
        if count > 1:
            yield f"{_shown(number)} is listed {count} times"


def _missing_functions(listed: EquationList) -> Iterator[str]:
    for entry in listed.implemented:
        if not entry.functions or not entry.tests:
            yield f"{entry.equations}: an implemented equation has a function and a test"
        for function in entry.functions:
            module, _, name = function.partition(":")
            try:
                found: Any = importlib.import_module(module)
                for part in name.split("."):
                    found = getattr(found, part)
            except (ImportError, AttributeError) as error:
                yield f"{entry.equations}: {function} cannot be imported ({error})"


def _missing_tests(listed: EquationList, root: Path) -> Iterator[str]:
    for entry in listed.implemented:
        for test in entry.tests:
            path, _, name = test.partition("::")
            if name not in _tests_in(root / path):
                yield f"{entry.equations}: there is no test {test}"


@cache
def _tests_in(path: Path) -> frozenset[str]:
    if not path.is_file():
        return frozenset()
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return frozenset(
        node.name
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    )


def _citations_elsewhere(listed: EquationList, root: Path) -> Iterator[str]:
    """Find equations that a library module cites, but that are listed for other modules only."""
    modules: dict[Number, set[str]] = {number: set() for entry in listed.left_out for number in entry.numbers}
    for entry in listed.implemented:
        for number in entry.numbers:
            modules[number] = {function.partition(":")[0] for function in entry.functions}
    left_out = {number for entry in listed.left_out for number in entry.numbers}
    cited: dict[Number, set[str]] = {}
    for module, numbers in citations(root).items():
        for number in numbers:
            cited.setdefault(number, set()).add(module)
    for number in sorted(cited):
        if number not in modules:
            yield f"{_shown(number)} is cited by {', '.join(sorted(cited[number]))}, but is not listed"
        elif number not in left_out and not cited[number] & modules[number]:
            yield (
                f"{_shown(number)} is cited by {', '.join(sorted(cited[number]))}, but listed with "
                f"{', '.join(sorted(modules[number]))} only"
            )


def citations(root: Path) -> dict[str, set[Number]]:
    """Return the equations of the thesis that the docstrings of each library module cite."""
    found: dict[str, set[Number]] = {}
    for library in LIBRARIES:
        folder = root / "src" / library / library
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder.parent).with_suffix("").parts
            module = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            numbers = _cited_in(path)
            if numbers:
                found[module] = numbers
    return found


def _cited_in(path: Path) -> set[Number]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef)
    texts: Sequence[str | None] = [ast.get_docstring(n) for n in ast.walk(tree) if isinstance(n, kinds)]
    lines = [" ".join((text or "").split()) for text in texts]
    return {
        number
        for line in lines
        for match in _CITED.finditer(line)
        for number in _range(match)
        if 2 <= number[0] <= 6 and "Fossen" not in line[max(0, match.start() - _NEAR) : match.start()]
    }


def _shown(number: Number) -> str:
    return f"({number[0]}.{number[1]})"
