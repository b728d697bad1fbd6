"""The frame `odom` of a vehicle: the dead reckoning without corrections (REP-105)."""

from __future__ import annotations

import math
from typing import NamedTuple

from auv_core.geometry import Quat, Vec3, quaternion_from_heading, quaternion_product


class OdomFrame(NamedTuple):
    """
    Pose of `odom` in the world: origin (m; NED) and rotation about the down axis (rad).

    A position fix moves the vehicle's estimate at once. REP-105 requires a pose in `odom` without jumps, so
    a fix moves this frame and not the pose in it.
    """

    north_m: float = 0.0
    east_m: float = 0.0
    turn_rad: float = 0.0

    def corrected(
        self, at_m: tuple[float, float], moved_m: tuple[float, float], turned_rad: float
    ) -> OdomFrame:
        """
        Return the frame after a correction of the vehicle's estimate.

        Parameters
        ----------
        at_m : (2,) tuple
            Estimated position before the correction (m; north, east).
        moved_m : (2,) tuple
            Change of the estimated position (m; north, east).
        turned_rad : float
            Change of the estimated heading (rad).

        """
        c, s = math.cos(turned_rad), math.sin(turned_rad)
        north_m, east_m = self.north_m - at_m[0], self.east_m - at_m[1]
        return OdomFrame(
            at_m[0] + moved_m[0] + c * north_m - s * east_m,
            at_m[1] + moved_m[1] + s * north_m + c * east_m,
            self.turn_rad + turned_rad,
        )

    def pose(self, position: Vec3, attitude: Quat) -> tuple[Vec3, Quat]:
        """Return a pose of the world (m, NED; body to NED) as seen from this frame."""
        if self == _WORLD:
            return position, attitude
        c, s = math.cos(self.turn_rad), math.sin(self.turn_rad)
        north_m, east_m = position[0] - self.north_m, position[1] - self.east_m
        seen = (c * north_m + s * east_m, c * east_m - s * north_m, position[2])
        return seen, quaternion_product(quaternion_from_heading(-self.turn_rad), attitude)


_WORLD = OdomFrame()
