"""Certificates of an H-infinity state feedback with x = [q, e, nu_e]: checks, and the value of x^T P x."""

from __future__ import annotations

from auv_core.geometry import Vec3
from auv_core.messages import Vec6


def check_feedback(name: str, gain: Vec3, riccati: Vec6, hull: tuple[float, float]) -> None:
    """
    Raise ValueError unless the loop of one axis is stable and P is positive definite.

    Parameters
    ----------
    name : str
        Name of the axis, with which its parameters begin.
    gain : (3,) tuple
        F on q, e and nu_e.
    riccati : (6,) tuple
        Upper triangle of P, by rows.
    hull : (2,) tuple
        Mass (kg) and linear damping (N s/m) of the axis.

    """
    q, e, v = gain
    mass, damping = hull
    if not (e > 0.0 and v > 0.0 and (damping + v) * e > mass * q):
        raise ValueError(
            f"{name}_gain: {list(gain)!r} is not allowed; allowed: gains of a stable loop, "
            "e and nu_e above 0 with (d_L + F_nu) F_e > m F_q"
        )
    if not is_positive_definite(riccati):
        raise ValueError(
            f"{name}_riccati: {list(riccati)!r} is not allowed; allowed: a positive definite matrix"
        )


def check_norms(achieved: tuple[float, ...], gamma: tuple[float, ...]) -> None:
    """Raise ValueError unless every achieved norm is at most its gamma."""
    for number, norm in enumerate(achieved):
        if norm > gamma[number]:
            raise ValueError(
                f"achieved_norm[{number}]: {norm!r} is not allowed; "
                f"allowed: at most gamma[{number}] = {gamma[number]!r}"
            )


def quadratic(p: Vec6, x: Vec3) -> float:
    """Return x^T P x for the upper triangle of P, by rows."""
    a, b, c = x
    return p[0] * a * a + p[3] * b * b + p[5] * c * c + 2.0 * (p[1] * a * b + p[2] * a * c + p[4] * b * c)


def is_positive_definite(p: Vec6) -> bool:
    """Return whether all leading minors of the symmetric matrix are above 0 (Sylvester)."""
    a, b, c = p[:3]
    d, e, f = p[3:]
    minor = a * d - b * b
    return a > 0.0 and minor > 0.0 and a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d) > 0.0
