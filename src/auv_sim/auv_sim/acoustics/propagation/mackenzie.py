"""Straight rays at the sound speed of sea water, from temperature, salinity and depth (Mackenzie 1981)."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3, distance
from auv_core.params import param
from auv_sim.acoustics.propagation import SoundPropagation
from auv_sim.acoustics.water import sound_speed_mps, transmission_loss_db


@dataclass(frozen=True)
class Params:
    """Sea water of constant salinity, with a linear temperature profile."""

    temperature_c: float = param(
        "temperature at the surface (degrees Celsius)", default=10.0, minimum=2.0, maximum=30.0
    )
    gradient_c_per_m: float = param(
        "change of temperature with depth (degrees Celsius per metre), down to 2 and up to 30 degrees",
        default=0.0, minimum=-1.0, maximum=1.0,
    )  # fmt: skip
    salinity_ppt: float = param("salinity (parts per thousand)", default=35.0, minimum=25.0, maximum=40.0)
    spreading_exponent: float = param(
        "k of the spreading loss 10 k log10(range): 2 spherical, 1 cylindrical, 1.5 practical",
        default=1.5, minimum=0.0, maximum=4.0,
    )  # fmt: skip


class Propagation(SoundPropagation):
    """
    Delay is range over the sound speed at the mean depth of source and receiver; loss as in `straight`.

    Rays are not bent: over the ranges of a flock a bent path is longer than a straight one by a few parts
    per million. Depth is the down coordinate; above the surface it counts as zero.
    """

    def __init__(self, params: Params) -> None:
        self._params = params

    def sound_speed_mps(self, depth_m: float) -> float:
        """Return the speed of sound (m/s) at a depth (m, down)."""
        p = self._params
        depth_m = min(max(depth_m, 0.0), 8000.0)
        temperature_c = min(max(p.temperature_c + p.gradient_c_per_m * depth_m, 2.0), 30.0)
        return sound_speed_mps(temperature_c, p.salinity_ppt, depth_m)

    def delay_s(self, source: Vec3, receiver: Vec3) -> float:
        """Return the travel time (s) between two NED positions (m)."""
        return distance(source, receiver) / self.sound_speed_mps(0.5 * (source[2] + receiver[2]))

    def loss_db(self, source: Vec3, receiver: Vec3, frequency_khz: float) -> float:
        """Return the transmission loss (dB) between two NED positions (m)."""
        return transmission_loss_db(
            distance(source, receiver), frequency_khz, self._params.spreading_exponent
        )
