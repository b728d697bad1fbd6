"""Collects what is asked of the actuators of a fleet, and their outputs, tick by tick."""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence

import numpy as np

from auv_core.messages import Command, Numbers, command_numbers
from auv_experiment.actuator_rows import ActuatorRows
from auv_experiment.recording import FloatArray, Recording

_NO_NUMBERS = (math.nan,) * 6


class ActuatorLog:
    """The actuators of a run in one process; it keeps nothing if no vehicle has one with a state."""

    def __init__(self, rows: ActuatorRows) -> None:
        self._rows = rows
        self._commands, self._outputs = array("d"), array("d")

    def command(self, index: int, command: Command) -> Numbers:
        """Return the six numbers of a vehicle's command, NaN for one of actuators with a state."""
        return _NO_NUMBERS if self._rows.counts[index] else command_numbers(command)

    def note(self, commands: Sequence[Command], outputs: Sequence[Numbers]) -> None:
        """Note the commands of a tick, and the outputs at its start."""
        if self._rows.most:
            for count, command, output in zip(self._rows.counts, commands, outputs, strict=True):
                self._commands.extend(self._padded(command_numbers(command) if count else ()))
                self._outputs.extend(self._padded(output))

    def put(self, recording: Recording, outputs: Sequence[Numbers]) -> None:
        """Put all of them into the recording of the run; `outputs` are those at its end."""
        last = [number for each in outputs for number in self._padded(each)]
        n, most = recording.n_vehicles, self._rows.most
        commands: FloatArray = np.array(self._commands).reshape(recording.n_ticks, n, most)
        reached: FloatArray = np.array([*self._outputs, *last]).reshape(recording.n_ticks + 1, n, most)
        self._rows.put(recording, commands, reached)

    def _padded(self, numbers: Numbers) -> Numbers:
        return (*numbers, *(self._rows.most - len(numbers)) * (math.nan,))
