"""
Rays that a sound speed profile bends and surface and bottom reflect: the Bellhop model, from a table.

Bellhop computes, once per source depth, the arrivals at a grid of depths and ranges; delay and loss are
interpolated between the grid's places. The interpolated quantities are smooth: the apparent speed of sound
along the straight line, and the loss beyond spherical spreading and absorption along that line. So the delay
goes to zero with the distance, and it is exact in water of constant sound speed.

The solver is optional: ``./scripts/setup --with bellhop`` installs it.

Source: Porter, The BELLHOP Manual and User's Guide (2011).
"""

from __future__ import annotations

import importlib.util
import io
import json
import math
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from auv_core.geometry import Vec3, distance
from auv_core.params import param
from auv_sim.acoustics.propagation import SoundPropagation
from auv_sim.acoustics.water import absorption_db_per_km, transmission_loss_db

# With this loss no modem recognises any possible source.
INAUDIBLE_DB = 300.0
_SOLVER = Path(__file__).with_name("_bellhop_solver.py")
_TIMEOUT_S = 120.0
_MAX_PLACES = 50_000
#  Rays do not depend on the frequency. The solver joins neighbouring rays of a path that differ by a small
# part of a period, so it gets a long period; levels are summed here, at the modem's frequency.
_RAY_HZ = 1000.0
_STEEPEST_DEG = 89.0

Floats = NDArray[np.float64]
Solver = Callable[[str], dict[str, Any]]


@dataclass(frozen=True)
class Params:
    """The water, its bottom, the grid of the table, and how arrivals at a place are combined."""

    water_depth_m: float = param("depth of the flat bottom (m)", default=100.0, minimum=1.0, maximum=11000.0)
    sound_speed_mps: tuple[float, ...] = param(
        "speed of sound (m/s): one value, or one for each of sound_speed_depths_m",
        default=(1500.0,), minimum=1300.0, maximum=1700.0,
    )  # fmt: skip
    sound_speed_depths_m: tuple[float, ...] = param(
        "depths of the sound speeds (m), from 0 and increasing; linear between, constant below the last",
        default=(0.0,), minimum=0.0, maximum=11000.0,
    )  # fmt: skip
    bottom_sound_speed_mps: float = param(
        "speed of sound in the bottom (m/s)", default=1600.0, minimum=1000.0, maximum=8000.0
    )
    bottom_density_kgpm3: float = param(
        "density of the bottom (kg/m3)", default=1600.0, minimum=900.0, maximum=8000.0
    )
    bottom_absorption_db: float = param(
        "absorption in the bottom (dB per wavelength)", default=0.1, minimum=0.0, maximum=20.0
    )
    max_range_m: float = param(
        "horizontal range of the table (m); beyond it a modem with sound levels receives nothing",
        default=2000.0, minimum=10.0, maximum=100000.0,
    )  # fmt: skip
    range_step_m: float = param("step of the table in range (m)", default=20.0, minimum=0.5, maximum=5000.0)
    depth_step_m: float = param(
        "step of the table in the depths of source and receiver (m)", default=5.0, minimum=0.1, maximum=5000.0
    )
    beams: int = param("rays from a source, over 178 degrees", default=2000, minimum=100, maximum=50000)
    arrival: str = param(
        "arrival that gives the travel time", default="first", choices=("first", "strongest")
    )
    sum: str = param(
        "whether powers or pressures of the arrivals are added; pressures need small steps",
        default="incoherent", choices=("incoherent", "coherent"),
    )  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse an invalid profile, and a table that is too large or has too few places."""
        depths_m = self.sound_speed_depths_m
        if len(depths_m) != len(self.sound_speed_mps):
            raise ValueError(
                f"sound_speed_depths_m: {len(depths_m)} depths are not allowed; "
                f"allowed: one for each of the {len(self.sound_speed_mps)} of sound_speed_mps"
            )
        if not depths_m or depths_m[0] != 0.0 or any(b <= a for a, b in pairwise(depths_m)):
            raise ValueError(
                f"sound_speed_depths_m: {list(depths_m)} is not allowed; allowed: 0, then increasing depths"
            )
        if self.range_step_m > 0.5 * self.max_range_m:
            raise ValueError(
                f"range_step_m: {self.range_step_m!r} is not allowed; allowed: at most half of max_range_m"
            )
        places = len(self.ranges_m()) * len(self.depths_m())
        if places > _MAX_PLACES:
            raise ValueError(
                f"range_step_m: a table of {places} places is not allowed; "
                f"allowed: at most {_MAX_PLACES}, by longer steps or a shorter max_range_m"
            )

    def ranges_m(self) -> Floats:
        """Return the ranges of the table (m), from one step on."""
        count = round(self.max_range_m / self.range_step_m)
        return np.linspace(self.max_range_m / count, self.max_range_m, count)

    def depths_m(self) -> Floats:
        """Return the depths of the table (m): the middles of at least two layers."""
        count = max(round(self.water_depth_m / self.depth_step_m), 2)
        middle_m = 0.5 * self.water_depth_m / count
        return np.linspace(middle_m, self.water_depth_m - middle_m, count)

    def speed_mps(self, depth_m: Any) -> Any:
        """Return the speed of sound (m/s) at a depth (m), or at an array of them."""
        return np.interp(depth_m, self.sound_speed_depths_m, self.sound_speed_mps)


class Propagation(SoundPropagation):
    """
    Delay and loss from tables that are solved when a source depth is first used, once per process.

    Below the first range the values of the first range are used; above the first and below the last depth,
    those of that depth. If no ray arrives, and beyond `max_range_m`, the delay is that of a straight line at
    the sound speed at half the depth, and nothing can be received.

    Raises
    ------
    ValueError
        If the solver is not installed.

    """

    def __init__(self, params: Params, solve: Solver | None = None) -> None:
        if solve is None and not is_installed():
            raise ValueError(
                "propagation.kind: 'bellhop' is not allowed, since its solver is not installed; "
                "allowed: another kind, or after ./scripts/setup --with bellhop"
            )
        self._params = params
        self._solve = solve or run_solver
        self._depths_m = params.depths_m()

    def delay_s(self, source: Vec3, receiver: Vec3) -> float:
        """Return the travel time (s) between two NED positions (m)."""
        slant_m = distance(source, receiver)
        range_m = self._range_m(source, receiver)
        if range_m > self._params.max_range_m:
            return slant_m / float(self._params.speed_mps(0.5 * (source[2] + receiver[2])))
        return slant_m / self._between(source[2], lambda table: table.speed_mps(receiver[2], range_m))

    def loss_db(self, source: Vec3, receiver: Vec3, frequency_khz: float) -> float:
        """Return the transmission loss (dB) between two NED positions (m)."""
        range_m = self._range_m(source, receiver)
        if range_m > self._params.max_range_m:
            return INAUDIBLE_DB
        excess_db = self._between(
            source[2], lambda table: table.excess_db(receiver[2], range_m, frequency_khz)
        )
        straight_db = transmission_loss_db(distance(source, receiver), frequency_khz, 2.0)
        return min(max(straight_db + excess_db, 0.0), INAUDIBLE_DB)

    @staticmethod
    def _range_m(source: Vec3, receiver: Vec3) -> float:
        return math.hypot(receiver[0] - source[0], receiver[1] - source[1])

    def _between(self, source_depth_m: float, value: Callable[[_Table], float]) -> float:
        """Return a value interpolated between the tables above and below a source."""
        place = float(np.interp(source_depth_m, self._depths_m, np.arange(len(self._depths_m))))
        above, share = int(place), place - int(place)
        result = value(_table(self._params, above, self._solve))
        if share > 0.0:
            result += share * (value(_table(self._params, above + 1, self._solve)) - result)
        return result


class _Table:
    """The arrivals from one source depth at every place of the grid."""

    def __init__(self, params: Params, source_depth_m: float, arrivals: dict[str, Any]) -> None:
        self._params = params
        self._depths_m, self._ranges_m = params.depths_m(), params.ranges_m()
        self._slants_m = np.hypot(self._ranges_m[:, None], self._depths_m[None, :] - source_depth_m).ravel()
        self._arrivals = arrivals
        self._place = np.repeat(np.arange(len(self._slants_m)), np.diff(arrivals["arrival_offset"]))
        straight_mps = params.speed_mps(0.5 * (self._depths_m + source_depth_m))
        times_s = self._slants_m / np.tile(straight_mps, len(self._ranges_m))
        # In this order the wanted arrival of a place comes last, and the last one written stays.
        keys = {"first": -arrivals["time_s"], "strongest": arrivals["amplitude"]}
        order = np.argsort(keys[params.arrival], kind="stable")
        times_s[self._place[order]] = arrivals["time_s"][order]
        self._speed_mps = self._grid(self._slants_m / times_s)
        self._excess_db: dict[float, RegularGridInterpolator] = {}

    def speed_mps(self, depth_m: float, range_m: float) -> float:
        """Return the apparent speed of sound (m/s) along the straight line to a place."""
        return self._at(self._speed_mps, depth_m, range_m)

    def excess_db(self, depth_m: float, range_m: float, frequency_khz: float) -> float:
        """Return by how much the loss exceeds that of a straight line with spherical spreading (dB)."""
        if frequency_khz not in self._excess_db:
            absorbed_db = absorption_db_per_km(frequency_khz) * self._slants_m / 1000.0
            straight_db = 20.0 * np.log10(np.maximum(self._slants_m, 1.0)) + absorbed_db
            self._excess_db[frequency_khz] = self._grid(self._losses_db(frequency_khz) - straight_db)
        return self._at(self._excess_db[frequency_khz], depth_m, range_m)

    def _losses_db(self, frequency_khz: float) -> Floats:
        """Return the loss (dB) at every place, with Thorp's absorption over each path's time."""
        time_s = self._arrivals["time_s"]
        path_km = time_s * float(np.mean(self._params.speed_mps(self._depths_m))) / 1000.0
        absorbed_db = absorption_db_per_km(frequency_khz) * path_km
        pressure = self._arrivals["amplitude"] * 10.0 ** (-0.05 * absorbed_db)
        if self._params.sum == "coherent":
            angle = self._arrivals["phase_rad"] - 2.0e3 * np.pi * frequency_khz * time_s
            power = self._sums(pressure * np.cos(angle)) ** 2 + self._sums(pressure * np.sin(angle)) ** 2
        else:
            power = self._sums(pressure**2)
        return -10.0 * np.log10(np.maximum(power, 10.0 ** (-0.1 * INAUDIBLE_DB)))

    def _sums(self, values: Floats) -> Floats:
        return np.bincount(self._place, values, len(self._slants_m)).astype(np.float64)

    def _grid(self, values: Floats) -> RegularGridInterpolator:
        shape = (len(self._ranges_m), len(self._depths_m))
        return RegularGridInterpolator((self._ranges_m, self._depths_m), values.reshape(shape))

    def _at(self, grid: RegularGridInterpolator, depth_m: float, range_m: float) -> float:
        inside_m = (
            min(max(range_m, self._ranges_m[0]), self._ranges_m[-1]),
            min(max(depth_m, self._depths_m[0]), self._depths_m[-1]),
        )
        return float(grid([inside_m])[0])


@lru_cache(maxsize=64)
def _table(params: Params, index: int, solve: Solver) -> _Table:
    """Return the table of the source at one of the depths of the grid."""
    depth_m = float(params.depths_m()[index])
    return _Table(params, depth_m, solve(json.dumps(_case(params, depth_m))))


def _case(params: Params, source_depth_m: float) -> dict[str, Any]:
    """Return the case for Bellhop, in the format of the solver: m, m/s, g/cm3, dB per wavelength."""
    bottom_m = params.water_depth_m
    depths_m = [depth_m for depth_m in params.sound_speed_depths_m if depth_m < bottom_m] + [bottom_m]
    return {
        "pelagic": 2, "model": "bellhop", "title": "shoal", "frequency": _RAY_HZ, "interpolation": "c_linear",
        "media": [{"to": bottom_m, "ssp": [[z, float(params.speed_mps(z))] for z in depths_m], "mesh": 1}],
        "surface": "vacuum",
        "bottom": {
            "type": "halfspace", "cp": params.bottom_sound_speed_mps,
            "rho": params.bottom_density_kgpm3 / 1000.0, "ap": params.bottom_absorption_db,
        },
        "source": {"depth": [source_depth_m]},
        "receivers": {"depth": params.depths_m().tolist(), "range": params.ranges_m().tolist()},
        "bellhop": {
            "run": "arrivals", "beam": "geometric_hat_cartesian",
            "angles": {"from": -_STEEPEST_DEG, "to": _STEEPEST_DEG, "count": params.beams},
            "box": {"depth": 1.01 * bottom_m, "range": 1.01 * params.max_range_m},
        },
    }  # fmt: skip


def is_installed() -> bool:
    """Return whether the solver is installed."""
    return importlib.util.find_spec("pelagic") is not None


def run_solver(case: str) -> dict[str, Any]:
    """
    Return the arrays that `_bellhop_solver` computes for a case.

    Raises
    ------
    RuntimeError
        If the solver fails or does not end in time, with the last line that it printed.

    """
    try:
        run = subprocess.run(
            [sys.executable, "-P", str(_SOLVER)],
            input=case.encode(), capture_output=True, timeout=_TIMEOUT_S, check=True,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"the Bellhop solver did not end within {_TIMEOUT_S:g} s") from None
    except subprocess.CalledProcessError as error:
        said = (error.stderr.decode(errors="replace").strip() or "nothing").splitlines()[-1]
        raise RuntimeError(f"the Bellhop solver failed with status {error.returncode}: {said}") from None
    with np.load(io.BytesIO(run.stdout), allow_pickle=False) as arrays:
        return dict(arrays)
