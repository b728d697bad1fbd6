"""Mass and added mass of a prolate spheroid, the shape that stands for a torpedo."""

from __future__ import annotations

import math
from typing import NamedTuple

from auv_core.geometry import Vec3
from auv_core.messages import Vec6


class Spheroid(NamedTuple):
    """A spheroid: semi-axes ahead and across (m)."""

    ahead_m: float
    across_m: float

    @property
    def volume_m3(self) -> float:
        """Volume (m^3)."""
        return 4.0 / 3.0 * math.pi * self.ahead_m * self.across_m * self.across_m

    def inertia_kgm2(self, mass_kg: float) -> Vec3:
        """Return the principal moments of inertia of a solid of this mass (kg m^2)."""
        a, b = self.ahead_m, self.across_m
        across = mass_kg * (a * a + b * b) / 5.0
        return (0.4 * mass_kg * b * b, across, across)

    def added_mass(self, mass_kg: float, roll_ratio: float) -> Vec6:
        """
        Return the added mass (kg) and added inertia (kg m^2) of a neutral hull of this mass.

        A spheroid that turns about its axis carries no water; `roll_ratio` is the added inertia of fins, over
        the inertia of the hull.
        """
        ahead, across, turning = self.lamb_factors()
        about_x, about_y, about_z = self.inertia_kgm2(mass_kg)
        angular = (roll_ratio * about_x, turning * about_y, turning * about_z)
        return (ahead * mass_kg, across * mass_kg, across * mass_kg, *angular)

    def lamb_factors(self) -> Vec3:
        """
        Return k_1, k_2 and k': added mass ahead and across, and added inertia across, each over the hull's.

        Notes
        -----
        Lamb (1932), Hydrodynamics, Art. 114, as in Fossen (2021) section 8.4. Deviation: a reprint of the
        coefficients of the LAUV takes the eccentricity without its root.

        """
        e = math.sqrt(1.0 - (self.across_m / self.ahead_m) ** 2)
        logarithm = math.log((1.0 + e) / (1.0 - e))
        alpha = 2.0 * (1.0 - e * e) / e**3 * (0.5 * logarithm - e)
        beta = 1.0 / (e * e) - (1.0 - e * e) / (2.0 * e**3) * logarithm
        square, difference = 2.0 - e * e, beta - alpha
        turning = e**4 * difference / (square * (2.0 * e * e - square * difference))
        return alpha / (2.0 - alpha), beta / (2.0 - beta), turning
