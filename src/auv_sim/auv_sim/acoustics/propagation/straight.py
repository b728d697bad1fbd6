"""Straight rays at one sound speed."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3, distance
from auv_core.params import param
from auv_sim.acoustics.propagation import SoundPropagation
from auv_sim.acoustics.water import transmission_loss_db


@dataclass(frozen=True)
class Params:
    """A constant sound speed, and the spreading of sound."""

    sound_speed_mps: float = param("speed of sound in the water (m/s)", default=1500.0, above=0.0)
    spreading_exponent: float = param(
        "k of the spreading loss 10 k log10(range): 2 spherical, 1 cylindrical, 1.5 practical",
        default=1.5, minimum=0.0, maximum=4.0,
    )  # fmt: skip


class Propagation(SoundPropagation):
    """Delay is range over sound speed; loss is spreading and Thorp's absorption."""

    def __init__(self, params: Params) -> None:
        self._speed_mps = params.sound_speed_mps
        self._exponent = params.spreading_exponent

    def delay_s(self, source: Vec3, receiver: Vec3) -> float:
        """Return the travel time (s) between two NED positions (m)."""
        return distance(source, receiver) / self._speed_mps

    def loss_db(self, source: Vec3, receiver: Vec3, frequency_khz: float) -> float:
        """Return the transmission loss (dB) between two NED positions (m)."""
        return transmission_loss_db(distance(source, receiver), frequency_khz, self._exponent)
