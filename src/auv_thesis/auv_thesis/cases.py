"""Sort the runs of several cases, each drawn equally often, by their case."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from typing import TypeVar

Case = TypeVar("Case", bound=Hashable)
Drawn = TypeVar("Drawn")


def by_case(cases: Collection[Case], drawn: Sequence[Drawn]) -> dict[Case, list[Drawn]]:
    """
    Return the runs of each case, in the order of the seeds.

    Parameters
    ----------
    cases : collection
        The cases, in their order.
    drawn : sequence
        All runs of the first case, then all of the second, and so on.

    Raises
    ------
    ValueError
        If the runs cannot be shared out equally.

    """
    each, left = divmod(len(drawn), len(cases))
    if left:
        raise ValueError(f"{len(drawn)} runs of {len(cases)} cases; allowed: equally many of each")
    return {case: list(drawn[each * i : each * (i + 1)]) for i, case in enumerate(cases)}
