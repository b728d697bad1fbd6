"""
Random numbers that belong to an event: the same (seed, purpose, source, destination, sequence) gives the
same number.
"""

from __future__ import annotations

import enum

import numpy as np

from auv_core.compiled import fastest, is_compiling
from auv_sim.seed_hash import LARGEST, first_word


class Purpose(enum.IntEnum):
    """The purpose of a random number; the values are part of every recorded result and must never change."""

    OUTAGE = 1
    NAVIGATION = 3
    SONAR = 4
    NOISE = 5
    MAC = 6
    BURST = 7
    FIX = 8
    OBSTACLE_SONAR = 14
    CURRENT = 15


def uniform(seed: int, purpose: Purpose, source: int, destination: int, sequence: int) -> float:
    """
    Return a number uniform on [0, 1), fixed by its arguments on every machine (NumPy's SeedSequence hash).
    """
    words = (seed, int(purpose), source, destination, sequence)
    if is_compiling() and max(words) <= LARGEST:
        word = fastest(first_word)(*words)
    else:
        word = int(np.random.SeedSequence(words).generate_state(1, np.uint64)[0])
    return (word >> 11) * 2.0**-53


def generator(seed: int, purpose: Purpose, address: int, tick: int) -> np.random.Generator:
    """Return a separate generator for one vehicle and one tick."""
    return np.random.default_rng(np.random.SeedSequence((seed, int(purpose), address, tick)))
