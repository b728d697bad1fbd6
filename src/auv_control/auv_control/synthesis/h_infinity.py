"""
Synthesis of H-infinity state feedback; `auv_control.synthesis.designs` has the laws that use it.

Along one axis, about a path flown at a steady speed, x = [q, e, nu_e] with q' = e, e' = nu_e and

    m nu_e' = -d nu_e - u + w,      d = d_L + 2 d_Q |speed|

u is what the law adds to its feed-forward, and w is the sum of all unknown forces. With scales for the
quantities to keep small, z = [q / q_max, e / e_max, nu_e / nu_max, u / u_max] and w in units of w_max, the
feedback u = F x keeps |z|_2 <= gamma |w|_2 if the Riccati equation

    A^T P + P A + C^T C + P (B1 B1^T / gamma^2 - B2 R^-1 B2^T) P = 0,      F = -R^-1 B2^T P

has a stabilising P > 0 (Doyle, Glover, Khargonekar, Francis 1989). A bisection finds the smallest gamma; it
is w_max / u_max, since integral action compensates a steady w with u = w. Near it the gains grow without
bound, so the law uses `margin` times this value.

The norm of the closed loop is computed without P, in two ways: by bisection on the eigenvalues of its
Hamiltonian matrix (Boyd, Balakrishnan, Kabamba 1989) and from a sweep of frequencies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, solve_continuous_are

Matrix = NDArray[np.float64]

_BISECTIONS = 45
_SWEEP_RADPS = np.logspace(-4.0, 3.0, 4001)


@dataclass(frozen=True)
class Weights:
    """
    Scales of the quantities to keep small and of the disturbance, and the margin above the smallest gain.
    """

    integral_ms: float = 2.0
    position_m: float = 0.2
    velocity_mps: float = 0.5
    force_n: float = 30.0
    disturbance_n: float = 20.0
    margin: float = 1.25
    speed_mps: float = 0.1


@dataclass(frozen=True)
class Plant:
    """x' = A x + B1 w + B2 u and z = [C x; u / force_n], with w in units of its scale."""

    a: Matrix
    b1: Matrix
    b2: Matrix
    c: Matrix
    r: float


@dataclass(frozen=True)
class Synthesis:
    """Feedback u = F x with the Riccati solution, the required gains and the achieved norms."""

    gain: Matrix
    riccati: Matrix
    gamma_best: float
    gamma: float
    norm_hamiltonian: float
    norm_sweep: float


def axis_plant(mass_kg: float, linear: float, quadratic: float, weights: Weights) -> Plant:
    """Return the weighted plant of one axis with mass (kg) and damping (N s/m, N s^2/m^2)."""
    damping = linear + 2.0 * quadratic * weights.speed_mps
    scales = (weights.integral_ms, weights.position_m, weights.velocity_mps)
    return Plant(
        a=np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -damping / mass_kg]]),
        b1=np.array([[0.0], [0.0], [weights.disturbance_n / mass_kg]]),
        b2=np.array([[0.0], [0.0], [-1.0 / mass_kg]]),
        c=np.diag([1.0 / scale for scale in scales]),
        r=weights.force_n**-2,
    )


def velocity_plant(mass_kg: float, linear: float, quadratic: float, weights: Weights) -> Plant:
    """
    Return the weighted plant of a velocity loop with integral action, x = [q, nu_e] with q' = nu_e: that of
    one axis without the integral of e, since q is what e is there.
    """
    axis = axis_plant(mass_kg, linear, quadratic, weights)
    return Plant(axis.a[1:, 1:], axis.b1[1:], axis.b2[1:], axis.c[1:, 1:], axis.r)


def synthesise(plant: Plant, margin: float) -> Synthesis:
    """Return the feedback for `margin` times the smallest possible gain."""
    best = _smallest_gamma(plant)
    gamma = margin * best
    riccati = riccati_solution(plant, gamma)
    if riccati is None:
        raise ValueError(f"margin: {margin!r} is not allowed; allowed: a number above 1")
    gain = feedback(plant, riccati)
    loop = closed_loop(plant, gain)
    return Synthesis(gain, riccati, best, gamma, hamiltonian_norm(*loop), sweep_norm(*loop))


def riccati_solution(plant: Plant, gamma: float) -> Matrix | None:
    """Return the stabilising P > 0 for a gain, None if there is none."""
    weight = np.diag([-gamma * gamma, plant.r])
    try:
        p = solve_continuous_are(plant.a, np.hstack([plant.b1, plant.b2]), plant.c.T @ plant.c, weight)
    except (LinAlgError, ValueError):
        return None
    p = 0.5 * (p + p.T)
    loop = plant.a + plant.b2 @ feedback(plant, p)
    worst = loop + plant.b1 @ plant.b1.T @ p / gamma**2
    is_stable = max(np.linalg.eigvals(matrix).real.max() for matrix in (loop, worst)) < 0.0
    return p if is_stable and np.linalg.eigvalsh(p).min() > 0.0 else None


def feedback(plant: Plant, riccati: Matrix) -> Matrix:
    """Return F = -R^-1 B2^T P, a row."""
    gain: Matrix = -(plant.b2.T @ riccati) / plant.r
    return gain


def closed_loop(plant: Plant, gain: Matrix) -> tuple[Matrix, Matrix, Matrix]:
    """Return A, B and C of the loop from w to z."""
    return plant.a + plant.b2 @ gain, plant.b1, np.vstack([plant.c, np.sqrt(plant.r) * gain])


def hamiltonian_norm(a: Matrix, b: Matrix, c: Matrix) -> float:
    """
    Return the H-infinity norm of C (sI - A)^-1 B by bisection: a gain is above it if no eigenvalue of
    [[A, B B^T / g^2], [-C^T C, -A^T]] lies on the imaginary axis.
    """
    low, high = 1e-9, 1e9
    for _ in range(_BISECTIONS):
        middle = np.sqrt(low * high)
        matrix = np.block([[a, b @ b.T / middle**2], [-c.T @ c, -a.T]])
        values = np.linalg.eigvals(matrix)
        touches = bool((np.abs(values.real) < 1e-7 * (1.0 + np.abs(values))).any())
        low, high = (middle, high) if touches else (low, middle)
    return float(high)


def sweep_norm(a: Matrix, b: Matrix, c: Matrix) -> float:
    """Return the largest singular value of C (jw - A)^-1 B over a sweep of w: the norm, or slightly less."""
    identity = np.eye(len(a))
    inputs = np.broadcast_to(b, (len(_SWEEP_RADPS), *b.shape))
    resolvents = np.linalg.solve(1j * _SWEEP_RADPS[:, np.newaxis, np.newaxis] * identity - a, inputs)
    return float(np.linalg.norm(c @ resolvents, ord=2, axis=(1, 2)).max())


def _smallest_gamma(plant: Plant) -> float:
    low, high = 1e-6, 1e6
    for _ in range(_BISECTIONS):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if riccati_solution(plant, middle) is None else (low, middle)
    return high
