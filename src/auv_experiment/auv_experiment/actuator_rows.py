"""The actuators of a fleet in a recording: how many each vehicle has, and the wrench of its thrusters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from auv_core.models import make_model, thrusters_of
from auv_core.params import Section
from auv_core.thrusters import Thrusters
from auv_experiment.recording import FloatArray, Recording


class ActuatorRows:
    """
    Writes what is asked of the actuators of a fleet into a recording.

    Attributes
    ----------
    counts : list of int
        Number of actuators with a state, for each vehicle.
    most : int
        The largest of them.

    """

    def __init__(self, models: Sequence[Section]) -> None:
        self.counts = [len(make_model(model).actuators) for model in models]
        self.most = max(self.counts, default=0)
        self._thrusters = [thrusters_of(model) for model in models]

    def put(self, recording: Recording, commands: FloatArray, outputs: FloatArray) -> None:
        """
        Put the numbers of all actuators into a recording, and the wrenches of thrusters.

        Parameters
        ----------
        recording : Recording
            Changed: the arrays of actuators, and `command` of vehicles that have some.
        commands, outputs : (K, N, most) and (K + 1, N, most) array
            What is asked of the actuators and their outputs; NaN ends shorter rows.

        """
        recording.actuator_command, recording.actuator_output = commands, outputs
        for index, thrusters in enumerate(self._thrusters):
            if thrusters.count:
                recording.command[:, index] = _wrenches(thrusters, outputs[1:, index, : thrusters.count])


def _wrenches(thrusters: Thrusters, forces_n: NDArray[np.float64]) -> FloatArray:
    """Return the wrenches (K, 6) of forces (K, n); summed one by one, which gives the same bits for any K."""
    T = thrusters.matrix()
    wrenches: FloatArray = np.zeros((len(forces_n), len(T)))
    for k in range(thrusters.count):
        wrenches += forces_n[:, k, np.newaxis] * T[:, k]
    return wrenches
