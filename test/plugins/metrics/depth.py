"""How well the vehicles keep one depth."""

import numpy as np

from auv_experiment.metrics import Meaning

MEANINGS = {"depth_spread_m": Meaning("m", "standard deviation of all depths over the run", 2)}


def compute(recording, scenario):
    """Return the spread of the depths."""
    return {"depth_spread_m": np.std(recording.position_ned_m[..., 2])}
