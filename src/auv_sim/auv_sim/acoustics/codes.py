"""
Error-correcting codes of modems, each as the probability of an error event per bit of data.

``convolutional_1_2_k9`` is the convolutional code of rate 1/2 and constraint length 9 with generators 561 and
753 (octal), decoded by Viterbi's algorithm from hard decisions. The probability is the union bound over paths
that leave the right one: the sum of a_d P_d, with a_d paths at distance d, and P_d the probability that more
than half of d bits are wrong (half of the ties count). Proakis, Digital Communications, convolutional codes.
"""

from __future__ import annotations

from collections.abc import Callable
from math import comb
from typing import NamedTuple

# Paths of the code (561, 753) by their distance from the right path, up to twice the free distance of 12.
PATHS_K9 = {12: 11, 14: 50, 16: 286, 18: 1630, 20: 9639, 22: 55152, 24: 320782}
# An error event more often than at every second bit says no more than a coin.
_COIN = 0.5


class Code(NamedTuple):
    """A code: bits of data per bit on the air, and what an error probability on the air becomes."""

    rate_ratio: float
    event_prob: Callable[[float], float]


def _uncoded(air_error_prob: float) -> float:
    return air_error_prob


def convolutional_k9_event_prob(air_error_prob: float) -> float:
    """Return the union bound of an error event per bit of data, at most 0.5."""
    bound = sum(paths * _pair_error_prob(distance, air_error_prob) for distance, paths in PATHS_K9.items())
    return min(bound, _COIN)


def _pair_error_prob(distance: int, air_error_prob: float) -> float:
    """Return the probability that the wrong one of two paths at an even distance looks nearer."""
    p, half = air_error_prob, distance // 2
    tie = 0.5 * comb(distance, half) * (p * (1.0 - p)) ** half
    return tie + sum(
        comb(distance, wrong) * p**wrong * (1.0 - p) ** (distance - wrong)
        for wrong in range(half + 1, distance + 1)
    )


CODES = {
    "none": Code(1.0, _uncoded),
    "convolutional_1_2_k9": Code(0.5, convolutional_k9_event_prob),
}
