"""The covariance of the errors of dead reckoning, and its update by a position fix."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class FixCorrection(NamedTuple):
    """Corrections by a position fix: of the position, and of the offsets of compass and log."""

    north_m: float
    east_m: float
    heading_rad: float
    surge_mps: float
    sway_mps: float


class Drift:
    """
    Covariance of the errors of a dead reckoning with constant offsets in heading and velocity.

    The error state is e = (north, east, heading, surge, sway): estimate minus truth of the horizontal
    position (m), and the remaining offsets of the compass (rad) and of the log along the body's x and y
    (m/s). Since the last fix

        e_p = e_p0 + S (e_heading, e_surge, e_sway) + noise,

    where S collects the effects of the offsets: a heading error rotates the displacement, a log error is
    integrated along the body's axes. Only S changes between fixes; the covariance of the offsets P_o and that
    of offsets and position P_op do not. The covariance of the position is therefore P_p = P_p0 + S P_op + (S
    P_op)' + S P_o S' + noise.

    Parameters
    ----------
    position_sd_m, heading_sd_rad, velocity_sd_mps : float
        Initial standard deviations, per axis; the five errors are then independent.
    learns : bool
        Whether a fix also corrects the offsets. If not, they keep their uncertainty, and the gain for the
        position takes them into account (Schmidt 1966).

    """

    def __init__(
        self, position_sd_m: float, heading_sd_rad: float, velocity_sd_mps: float, *, learns: bool
    ) -> None:
        self._learns = learns
        self._noise_m2 = 0.0
        self._clear()
        sd = [position_sd_m, position_sd_m, heading_sd_rad, velocity_sd_mps, velocity_sd_mps]
        self._keep(np.diag(np.square(sd)))

    def advance(
        self, moved_m: tuple[float, float], axes: tuple[float, float, float, float], dt_s: float, sd_m: float
    ) -> None:
        """
        Advance by one interval.

        Parameters
        ----------
        moved_m : (2,) tuple
            Displacement over it (m; north, east).
        axes : (4,) tuple
            North and east parts of the body's x axis, then of its y axis.
        dt_s : float
            Its length (s).
        sd_m : float
            White noise of the displacement, per axis (m).

        """
        self._moved_n_m += moved_m[0]
        self._moved_e_m += moved_m[1]
        self._xn_s += dt_s * axes[0]
        self._xe_s += dt_s * axes[1]
        self._yn_s += dt_s * axes[2]
        self._ye_s += dt_s * axes[3]
        self._noise_m2 += sd_m * sd_m

    @property
    def position_variance_m2(self) -> float:
        """Variance of the position: mean of north and east (m^2)."""
        n, e, xn, xe, yn, ye = (
            self._moved_n_m,
            self._moved_e_m,
            self._xn_s,
            self._xe_s,
            self._yn_s,
            self._ye_s,
        )
        hh, hx, hy, xx, xy, yy = self._offsets
        (hn, he), (xpn, xpe), (ypn, ype) = self._cross
        # trace of S P_o S' with S = [[-e, xn, yn], [n, xe, ye]], and twice that of S P_op
        own = hh * (n * n + e * e) + xx * (xn * xn + xe * xe) + yy * (yn * yn + ye * ye)
        own += 2.0 * (hx * (n * xe - e * xn) + hy * (n * ye - e * yn) + xy * (xn * yn + xe * ye))
        mixed = n * he - e * hn + xn * xpn + xe * xpe + yn * ypn + ye * ype
        return 0.5 * (self._start_m2 + own) + mixed + self._noise_m2

    @property
    def heading_variance_rad2(self) -> float:
        """Variance of the heading (rad^2)."""
        return self._offsets[0]

    def covariance(self) -> FloatArray:
        """Return the (5, 5) covariance of e."""
        carried = np.eye(5)
        carried[0, 2:] = -self._moved_e_m, self._xn_s, self._yn_s
        carried[1, 2:] = self._moved_n_m, self._xe_s, self._ye_s
        P: FloatArray = carried @ self._P @ carried.T
        P[:2, :2] += self._noise_m2 * np.eye(2)
        return P

    def correct(self, off_m: tuple[float, float], sd_m: float) -> FixCorrection:
        """
        Use a position fix (Kalman update in Joseph form).

        Parameters
        ----------
        off_m : (2,) tuple
            Fix minus estimate (m; north, east).
        sd_m : float
            Standard deviation of the fix per axis (m).

        Returns
        -------
        correction : FixCorrection
            North and east: to be added to the position; heading, surge and sway: to be subtracted from now
            on.

        """
        P = self.covariance()
        R = sd_m * sd_m * np.eye(2)
        # With an exact start and an exact fix there is nothing to correct, and the matrix is singular.
        K = P[:, :2] @ np.linalg.pinv(P[:2, :2] + R, hermitian=True)
        if not self._learns:
            K[2:] = 0.0
        kept = np.eye(5)
        kept[:, :2] -= K
        self._keep(kept @ P @ kept.T + K @ R @ K.T)
        self._clear()
        north, east, *offsets = (K @ np.array(off_m)).tolist()
        heading, surge, sway = (-offset for offset in offsets)
        return FixCorrection(north, east, heading, surge, sway)

    def _clear(self) -> None:
        """Reset S."""
        self._moved_n_m = self._moved_e_m = 0.0
        self._xn_s = self._xe_s = self._yn_s = self._ye_s = 0.0
        self._noise_m2 = 0.0

    def _keep(self, P: FloatArray) -> None:
        """Keep the covariance at a fix as plain numbers, too, for fast use in every tick."""
        self._P = 0.5 * (P + P.T)
        rows = self._P.tolist()
        self._start_m2 = rows[0][0] + rows[1][1]
        self._offsets = (rows[2][2], rows[2][3], rows[2][4], rows[3][3], rows[3][4], rows[4][4])
        self._cross = tuple((row[0], row[1]) for row in rows[2:])
