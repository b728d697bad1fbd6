"""
A run as arrays, for metrics, figures and the report.

A recording comes from a bag or directly from an in-process run, and is the same in both cases. It holds K
control ticks of N vehicles; arrays are indexed (tick, vehicle, component), so `x[k, i]` belongs to scenario
time `t_s[k]` and vehicle `vehicle_ids[i]`, whose acoustic address is `i + 1`. Positions and their rates are
in map_ned (north, east, down), body quantities forward-right-down. NaN marks values that do not exist, such
as the estimate of a neighbour that was never heard, or the command of a lost vehicle.
"""

from __future__ import annotations

import math
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from auv_core.machine.free_memory import free_bytes, gigabytes
from auv_core.machine.whole_files import whole_file
from auv_core.messages import AcousticEvent, Outcome
from auv_experiment.recording_shapes import NEIGHBOURS, dtype_of, fits, shapes_of

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

FORMAT_VERSION = 4
_VERSION_KEY = "format_version"
_TOLERANCE_S = 1e-9
_VALUES_OF_ROWS = (("delay_s", "received"), ("contact_values", "contacts"), ("event_values", "events"))


class RecordingError(ValueError):
    """Raised if the arrays of a recording do not match, or a file has no recording."""


@dataclass(eq=False)
class Recording:
    """
    One run of N vehicles over K control ticks.

    Attributes
    ----------
    vehicle_ids : tuple of N str
        Names in the scenario's order; vehicle i has the acoustic address i + 1.
    t_s : (K + 1,) array
        Scenario time of each state, from 0; state k + 1 is the result of command k.
    position_ned_m : (K + 1, N, 3) array
        True position of the hull centres (m, map_ned).
    attitude_quat_wxyz : (K + 1, N, 4) array
        True attitude as unit quaternion, scalar first; rotates body to NED.
    velocity_body : (K + 1, N, 6) array
        True nu = [u, v, w, p, q, r] (m/s, rad/s; body FRD).
    command : (K, N, 6) array
        Wrench (N, N m; body FRD) commanded to the actuators; for a kinematic vehicle velocity (m/s, NED) in
        the first three components and yaw rate (rad/s) in the last; for thrusters the wrench of their
        forces at the end of the period; NaN for fins.
    actuator_command, actuator_output : (K, N, A) and (K + 1, N, A) arrays
        What was asked of each actuator that has a state, and its output (N, rad or rpm; see
        `auv_core.models.VehicleModel.actuators`); A is the largest number, and NaN ends shorter rows.
    reference_velocity_ned_mps : (K, N, 3) array
        Velocity commanded by the flocking law, or that of the vehicle's own path (m/s, NED).
    centre_ned_m, centre_velocity_ned_mps : (K, N, 3) arrays
        Each vehicle's own estimate of the flocking centre (m and m/s, NED).
    law_state : (K, N, S) array
        State of each vehicle's law (such as parameter estimates; see the law); S is the largest size.
    holding : (K, N) array of int64
        Why the agent gave the safe command instead of the law's, see `auv_flocking.holding.cause_number`; 0
        if the law acted.
    neighbour_position_ned_m, neighbour_velocity_ned_mps : (K, N, N, 3) arrays
        These and the other arrays of neighbours have no rows if there are no neighbour estimates.
        Estimate [k, i, j] of vehicle j by vehicle i (m and m/s, NED).
    neighbour_covariance : (K, N, N, 6, 6) array
        Covariance of position and velocity, in this order (m^2, m^2/s, m^2/s^2; NED).
    neighbour_age_s, neighbour_sonar_age_s : (K, N, N) arrays
        Age of the newest packet in the estimate, and time since the sonar saw the neighbour (s; inf: never).
    nav_position_ned_m : (K, N, 3) array
        Position of the vehicle by its own navigation (m, map_ned).
    nav_position_sd_m : (K, N) array
        Its standard deviation per horizontal axis, as the navigation states it (m).
    contacts : (C, 2) array of int64
        Tick of a sonar contact, and address of the vehicle with the sonar.
    contact_values : (C, 3) array
        Range (m), bearing and elevation (rad; body FRD, elevation positive up), per row of `contacts`.
    sent : (S, 3) array of int64
        Tick in which the packet was passed to the modem, source address, sequence number.
    received : (R, 4) array of int64
        Tick of delivery, source address, destination address, sequence number.
    delay_s : (R,) array
        End of reception minus start of transmission, per row of `received` (s).
    events : (E, 6) array of int64
        The acoustic log: tick in which the event was logged, `Outcome`, source address, destination address
        (0 in a SENT row of a broadcast), sequence number, payload size (bytes).
    event_values : (E, 3) array
        First and last moment of the signal, at the sender in SENT rows, else at the receiver (s), and the
        ratio of signal to ambient noise (dB, NaN if the channel has none), per row of `events`.
    lost_at_s : (N,) array
        Scenario time at which the vehicle's computer was lost, NaN if it never was (s).

    """

    vehicle_ids: tuple[str, ...]
    t_s: FloatArray
    position_ned_m: FloatArray
    attitude_quat_wxyz: FloatArray
    velocity_body: FloatArray
    command: FloatArray
    actuator_command: FloatArray
    actuator_output: FloatArray
    reference_velocity_ned_mps: FloatArray
    centre_ned_m: FloatArray
    centre_velocity_ned_mps: FloatArray
    law_state: FloatArray
    holding: IntArray
    neighbour_position_ned_m: FloatArray
    neighbour_velocity_ned_mps: FloatArray
    neighbour_covariance: FloatArray
    neighbour_age_s: FloatArray
    neighbour_sonar_age_s: FloatArray
    nav_position_ned_m: FloatArray
    nav_position_sd_m: FloatArray
    contacts: IntArray
    contact_values: FloatArray
    sent: IntArray
    received: IntArray
    delay_s: FloatArray
    events: IntArray
    event_values: FloatArray
    lost_at_s: FloatArray

    def __post_init__(self) -> None:
        """Convert the arrays to their types and check that their shapes match."""
        self.vehicle_ids = tuple(str(name) for name in self.vehicle_ids)
        for name, shape in shapes_of(len(self.t_s), len(self.vehicle_ids)).items():
            array = np.asarray(getattr(self, name), dtype=dtype_of(name))
            if array.size == 0 and None in shape:
                array = array.reshape([size or 0 for size in shape])
            if name in NEIGHBOURS and len(array) == 0:
                shape = (0, *shape[1:])
            if not fits(array.shape, shape):
                raise RecordingError(f"{name}: shape {array.shape}, expected {shape}")
            setattr(self, name, array)
        for values, keys in _VALUES_OF_ROWS:
            rows, expected = len(getattr(self, values)), len(getattr(self, keys))
            if rows != expected:
                raise RecordingError(f"{values}: {rows} rows for the {expected} of {keys}")

    @classmethod
    def empty(
        cls, vehicle_ids: Sequence[str], t_s: NDArray[np.floating[Any]], *, has_neighbours: bool = True
    ) -> Recording:
        """
        Return an empty recording of the right shapes.

        Parameters
        ----------
        vehicle_ids : sequence of N str
            Names in the scenario's order.
        t_s : (K + 1,) array
            Scenario time of each state (s).
        has_neighbours : bool
            False if there are no neighbour estimates: the arrays of neighbours, which grow with the square
            of N, then have no rows.

        Returns
        -------
        recording : Recording
            All per-tick arrays full of NaN, no packets, no vehicle lost.

        """
        arrays: dict[str, Any] = {}
        for name, shape in shapes_of(len(t_s), len(vehicle_ids)).items():
            fill_value = np.nan if dtype_of(name) is np.float64 else 0
            if name in NEIGHBOURS and not has_neighbours:
                shape = (0, *shape[1:])
            arrays[name] = np.full([size or 0 for size in shape], fill_value, dtype=dtype_of(name))
        arrays["t_s"] = np.array(t_s, dtype=np.float64)
        return cls(vehicle_ids=tuple(vehicle_ids), **arrays)

    @property
    def n_vehicles(self) -> int:
        """Number of vehicles N."""
        return len(self.vehicle_ids)

    @property
    def n_ticks(self) -> int:
        """Number of control ticks K; there are K + 1 states."""
        return len(self.t_s) - 1

    @property
    def has_neighbours(self) -> bool:
        """Whether there are arrays of neighbours."""
        return len(self.neighbour_age_s) > 0

    @property
    def is_gone(self) -> NDArray[np.bool_]:
        """Return (K + 1, N) flags: the vehicle has been lost by that time."""
        lost_at_s = np.where(np.isnan(self.lost_at_s), np.inf, self.lost_at_s)
        gone: NDArray[np.bool_] = self.t_s[:, np.newaxis] >= lost_at_s - _TOLERANCE_S
        return gone

    def save(self, path: str | Path) -> Path:
        """
        Write the recording as a compressed .npz file, completely or not at all.

        Equal recordings give equal bytes. The fastest compression is used, since covariances hardly compress
        and would take seconds.

        Raises
        ------
        WriteError
            If the file cannot be written, as on a full disk.

        """
        path = Path(path)
        with (
            whole_file(path) as unfinished,
            zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        ):
            _write_array(archive, _VERSION_KEY, np.array(FORMAT_VERSION))
            for field in fields(self):
                _write_array(archive, field.name, np.asarray(getattr(self, field.name)))
        return path

    @classmethod
    def load(cls, path: str | Path) -> Recording:
        """Read a file that `save` has written; raise RecordingError, one line, for any other file."""
        try:
            _check_size(Path(path))
            with np.load(path, allow_pickle=False) as archive:
                version = int(archive[_VERSION_KEY])
                if version != FORMAT_VERSION:
                    raise RecordingError(f"format {version}, this program reads {FORMAT_VERSION}")
                return cls(**{field.name: archive[field.name] for field in fields(cls)})
        except RecordingError as error:
            raise RecordingError(f"{path}: {error}") from None
        except Exception as error:  # each layer of a damaged file has its own exceptions
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            raise RecordingError(f"{path} is damaged or not a recording ({reason})") from error


def acoustic_log(recording: Recording) -> list[AcousticEvent]:
    """Return the lines of the acoustic log."""
    return [
        AcousticEvent(Outcome(outcome), source, destination, sequence, start_s, end_s, snr_db, size_bytes)
        for (_, outcome, source, destination, sequence, size_bytes), (start_s, end_s, snr_db) in zip(
            recording.events.tolist(), recording.event_values.tolist(), strict=True
        )
    ]


def _check_size(path: Path) -> None:
    """Raise RecordingError for a file that unpacks to more than the free memory of this machine."""
    with zipfile.ZipFile(path) as archive:
        unpacked = sum(_stated_bytes(archive, member) for member in archive.infolist())
    free = free_bytes()
    if unpacked > free:
        raise RecordingError(f"it unpacks to {gigabytes(unpacked)}, and {gigabytes(free)} of memory are free")


def _stated_bytes(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> int:
    """Return the size of an array by its header or by its place in the archive, whichever is larger."""
    with archive.open(member) as stream:
        read_header = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }[np.lib.format.read_magic(stream)]
        shape, _, dtype = read_header(stream)
    return max(member.file_size, math.prod(shape) * dtype.itemsize)


def _write_array(archive: zipfile.ZipFile, name: str, array: NDArray[Any]) -> None:
    with archive.open(f"{name}.npy", "w", force_zip64=True) as stream:
        np.lib.format.write_array(stream, array, allow_pickle=False)
