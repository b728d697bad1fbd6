"""
What a report says about hearing: from which vehicles the sender has news, and how old at most.

A vehicle learns with it which of its own reports a neighbour surely holds. A report has one age class, chosen
by the sender, and a mask: bit (address - 1) mod 16 stands for all vehicles with this residue, except the
sender. It is set if the sender holds a report of every one of them with a time tag at most so old, at its own
time tag. A fleet of more than 16 vehicles shares bits, and a set bit is then true of all that share it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

CODES = 16
BITS = 16


def within_s(code: int) -> float:
    """Return the largest age that a class stands for (s): 1 s to 181 s, in steps of the square root of 2."""
    return float(2.0 ** (0.5 * code))


def bit_of(address: int) -> int:
    """Return the bit of the vehicle with this address, as a number with one bit set."""
    return 1 << (address - 1) % BITS


def mask_of(ages_s: Mapping[int, float], own_address: int, fleet_size: int, code: int) -> int:
    """
    Return the mask of a report.

    Parameters
    ----------
    ages_s : mapping
        Age of the newest report from each vehicle that was heard, by address (s).
    own_address, fleet_size : int
        Address of the sender, and number of vehicles; their addresses begin with 1.
    code : int
        The age class.

    """
    heard = missing = 0
    for address in range(1, fleet_size + 1):
        if address == own_address:
            continue
        if ages_s.get(address, math.inf) <= within_s(code):
            heard |= bit_of(address)
        else:
            missing |= bit_of(address)
    return heard & ~missing


def class_of_all(ages_s: Mapping[int, float], at_most_s: float = math.inf) -> int:
    """
    Return the smallest class that holds all ages of at most `at_most_s`, or the largest class.

    Older ones are those of vehicles that may be lost: with them the class would be so coarse that the mask
    says nothing of the others.
    """
    oldest_s = max((age_s for age_s in ages_s.values() if age_s <= at_most_s), default=0.0)
    return next((code for code in range(CODES) if oldest_s <= within_s(code)), CODES - 1)
