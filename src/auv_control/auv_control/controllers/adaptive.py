"""
Adaptive trajectory tracking, the formation law of thesis chapter 3: every vehicle follows its own path.

With e = eta - eta_d (NED, yaw error in (-pi, pi]), s = e' + LAM e, estimates a^ of the vehicle's constants
and a regressor Y, thesis Eqs. (3.9)-(3.12):

    tau = Y a^ - K_D s          a^' = -GAM Y^T s

``mode: thesis`` gives the thesis's figures. Y is computed from the path alone (3.16)-(3.19),

    row i of Y = [ eta_d'',  |eta_d'| eta_d' ]_i        a^ = [m11 dQ1 m22 dQ2 m33 dQ3 m44 dQ4]     (3.20)

and the frame selects how the forces act: ``flat`` is J = I, (3.15) as printed; ``body`` rotates the forces
into the body frame; ``mixed`` applies them there without rotation, with which the vehicle never arrives.

``mode: corrected`` is the law of the proof (3.21)-(3.36): body frame, virtual reference
eta_r' = eta_d' - LAM e, nu_r = J^T eta_r', s = nu - nu_r, the twelve constants of `body_regressor`, so that

    V = s^T M s / 2 + a~^T GAM^-1 a~ / 2        V' = -s^T (K_D + D(nu)) s <= 0

Options for both: `blend_s` lets the reference start at the vehicle, `leakage_ps` pulls the estimates back to
their initial values, `box` keeps them within [low_ratio, high_ratio] of the nominal values (plus
`high_extra`). The estimates stay constant while the law is at its own force limit.

Deviation: thesis (3.12) requires a positive definite GAM and Table 3.1 gives three zeros; a zero freezes its
estimate here, and sums over GAM^-1 leave it out. Deviation: thesis (3.29) calls M' - 2 (C + D)
skew-symmetric; this is true for M' - 2 C, and D helps. Deviation: (3.13) leaves out C without comment; mode
``corrected`` has it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from auv_control.body_regressor import Vec4, body_forces, transposed_times
from auv_control.controllers import MotionLaw, MotionView
from auv_control.path_motion import Motion, composite_error, motion_of, virtual_motion
from auv_control.references import PathPoint
from auv_control.start_blend import wrapped
from auv_core.geometry import heading_from_quaternion
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.params import param

Rates = tuple[float, ...]


@dataclass(frozen=True)
class Params:
    """
    Four-vectors are in the order x, y, z, yaw (flat frame) or surge, sway, heave, yaw (body frame).

    The defaults are the corrected law on the vehicle of thesis Table 3.1; the thesis's own gains are in the
    preset ``adaptive_thesis``.
    """

    mode: str = param("which law", default="corrected", choices=("thesis", "corrected"))
    frame: str = param(
        "frame of nu and forces: NED (flat), the body, or NED forces applied in the body frame (mixed)",
        default="body",
        choices=("flat", "body", "mixed"),
    )
    error_gain: Vec4 = param(
        "diagonal of K_D (N s/m, N m s/rad)", default=(200.0, 200.0, 300.0, 60.0), above=0.0
    )
    error_rate_ps: Vec4 = param("diagonal of LAM (1/s)", default=(0.5, 0.5, 0.5, 0.5), above=0.0)
    nominal_inertia: Vec4 = param(
        "nominal masses (kg) and moment of inertia (kg m^2)",
        default=(99.0, 108.5, 126.5, 29.1),
        above=0.0,
    )
    nominal_linear_damping: Vec4 = param(
        "nominal d_L (N s/m, N m s/rad)", default=(10.0, 0.0, 10.0, 1.603), minimum=0.0
    )
    nominal_quadratic_damping: Vec4 = param(
        "nominal d_Q (N s^2/m^2, N m s^2/rad^2)",
        default=(227.18, 405.42, 227.18, 12.937),
        minimum=0.0,
    )
    initial_ratio: float = param("initial estimates / nominal values", default=1.0, minimum=0.0, maximum=10.0)
    inertia_adaptation: Vec4 = param(
        "GAM of the masses (kg s^2/m^2) and the inertia; 0 freezes",
        default=(100.0, 100.0, 100.0, 30.0),
        minimum=0.0,
    )
    linear_adaptation: Vec4 = param(
        "GAM of d_L (kg/m^2; yaw kg m^2); 0 freezes; zeros in mode thesis",
        default=(100.0, 100.0, 100.0, 10.0),
        minimum=0.0,
    )
    quadratic_adaptation: Vec4 = param(
        "GAM of d_Q (kg s^2/m^4; yaw kg m^2 s^2); 0 freezes",
        default=(400.0, 600.0, 400.0, 10.0),
        minimum=0.0,
    )
    box: bool = param("whether the estimates are kept in their box", default=True)
    low_ratio: float = param("lower end of the box / nominal value", default=0.2, minimum=0.0, maximum=1.0)
    high_ratio: float = param("upper end of the box / nominal value", default=3.0, minimum=1.0)
    high_extra: float = param("added to the upper end of the box (kg, N s/m, ...)", default=20.0, minimum=0.0)
    leakage_ps: float = param(
        "sigma of a^' = ... - sigma GAM (a^ - a^(0)) (1/s at unit GAM)", default=0.0, minimum=0.0
    )
    blend_s: float = param(
        "time in which the reference moves from the start to the path (s)", default=40.0, minimum=0.0
    )
    max_force_n: float | None = param("force limit per axis (N); null: none", default=None, above=0.0)
    max_moment_nm: float | None = param("limit of the yaw moment (N m); null: none", default=None, above=0.0)

    def __post_init__(self) -> None:
        if self.mode == "corrected" and self.frame != "body":
            raise ValueError(f"frame: {self.frame!r} is not allowed; allowed: body, with mode corrected")
        if self.mode == "thesis" and any(self.linear_adaptation):
            raise ValueError(
                f"linear_adaptation: {self.linear_adaptation!r} is not allowed; allowed: zeros with mode "
                "thesis, whose eight parameters have no linear damping"
            )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the estimates, in the order of the law's state."""
        if self.mode == "thesis":
            return tuple(name for i in "1234" for name in (f"m{i}{i}", f"dQ{i}"))
        return tuple(name.format(i) for name in ("m{0}{0}", "dL{0}", "dQ{0}") for i in "1234")


class Controller(MotionLaw):
    """
    The law of one vehicle.

    Its state is the estimates (as `Params.names`), and with a blend the time of the start (s) and the offset
    eta(0) - eta_ref(0) (m, rad; NED).
    """

    command = "wrench"
    follows = "path"
    candidates = ("thesis", "corrected")
    shared_candidate = False
    proof_gap = (
        "the proof (3.26)-(3.36) needs the virtual reference eta_d' - LAM e in Y; the law as simulated uses "
        "the path instead, for which passivity from Y a~ to s needs K_D + D >= M LAM: Table 3.1 is too "
        "small by a factor of 42 to 250; and with three zeros in GAM, GAM^-1 is undefined"
    )

    def __init__(self, params: Params, period_s: float) -> None:
        p = self.params = params
        self._is_thesis = p.mode == "thesis"
        if not self._is_thesis:
            self.proof_gap = (
                "V decreases if drag and inertia are the twelve nominal constants; the proof does not cover "
                "moving water, force limits, noise, sampling, leakage and constants outside the box"
            )
        self._nominal = self._ordered(
            p.nominal_inertia, p.nominal_linear_damping, p.nominal_quadratic_damping
        )
        self._gains = self._ordered(p.inertia_adaptation, p.linear_adaptation, p.quadratic_adaptation)
        self._count = len(self._gains)
        self._low = tuple(p.low_ratio * x for x in self._nominal)
        self._high = tuple(p.high_ratio * x + p.high_extra for x in self._nominal)
        first = tuple(p.initial_ratio * x for x in self._nominal)
        self._first = self._boxed(first) if p.box else first
        self._max_force_n = math.inf if p.max_force_n is None else p.max_force_n
        self._max_moment_nm = math.inf if p.max_moment_nm is None else p.max_moment_nm

    def initial_state(self, view: MotionView) -> State:
        """Return the initial estimates, and with a blend its start."""
        if self.params.blend_s == 0.0:
            return self._first
        path = _path(view)
        x, y, z = view.nav.position
        psi = heading_from_quaternion(view.nav.attitude)
        px, py, pz = path.position
        return (*self._first, view.t_s, x - px, y - py, z - pz, wrapped(psi - path.heading_rad))

    def constrained(self, state: State) -> State:
        """Return `state` with the estimates in their box."""
        return (*self._boxed(state[: self._count]), *state[self._count :]) if self.params.box else state

    def evaluate(self, state: State, view: MotionView) -> tuple[Vec6, Rates]:
        """
        Return the wrench (N, N m) and the rate of the law's state, thesis Eqs. (3.10) and (3.12).

        Parameters
        ----------
        state : tuple
            Estimates, and the start of the blend.
        view : MotionView
            Own navigation and the path (m, m/s, rad; NED).

        """
        motion = self._motion(state, view)
        tau, direction = self._printed(state, motion) if self._is_thesis else self._virtual(state, motion)
        x, y, z, n = tau
        f, m = self._max_force_n, self._max_moment_nm
        if abs(x) > f or abs(y) > f or abs(z) > f or abs(n) > m:
            limited = (_clipped(x, f), _clipped(y, f), _clipped(z, f), 0.0, 0.0, _clipped(n, m))
            return limited, (0.0,) * len(state)
        rates = [-gain * d for gain, d in zip(self._gains, direction, strict=True)]
        sigma = self.params.leakage_ps
        if sigma:
            rates = [
                rate - sigma * gain * (a - a0)
                for rate, gain, a, a0 in zip(rates, self._gains, state, self._first, strict=False)
            ]
        return (x, y, z, 0.0, 0.0, n), (*rates, *(0.0,) * (len(state) - self._count))

    def lyapunov(
        self, state: State, view: MotionView, kinetic_energy: Callable[[Vec6], float]
    ) -> tuple[float, float]:
        """
        Return the printed candidate and ours (J); the nominal values are assumed to be the true ones.

        ``thesis`` is (3.21) with s = e' + LAM e and the adapted ones of the eight parameters. ``corrected``
        is, in mode ``corrected``, V with the body's s and the adapted ones of the twelve; in mode
        ``thesis``, for which no decreasing V of that kind is known, the energy e'^T M e' / 2 + e^T K_D LAM e
        / 2 of the loop without adaptation.
        """
        motion = self._motion(state, view)
        s = composite_error(motion, self.params.error_rate_ps)
        printed = kinetic_energy(_six(s))
        if self._is_thesis:
            e = motion.error
            stiffness = zip(self.params.error_gain, self.params.error_rate_ps, e, strict=True)
            energy = kinetic_energy(_six(motion.error_rate)) + 0.5 * sum(
                k * c * x * x for k, c, x in stiffness
            )
            return printed + self._estimate_energy(state, range(8)), energy
        nu, nu_r, _ = virtual_motion(motion, self.params.error_rate_ps)
        own_s = (nu[0] - nu_r[0], nu[1] - nu_r[1], nu[2] - nu_r[2], nu[3] - nu_r[3])
        eight = (0, 1, 2, 3, 8, 9, 10, 11)
        return (
            printed + self._estimate_energy(state, eight),
            kinetic_energy(_six(own_s)) + self._estimate_energy(state, range(12)),
        )

    def _printed(self, state: State, motion: Motion) -> tuple[Vec4, Rates]:
        """Return tau of (3.10) and Y^T s, with the regressor (3.19) along the path."""
        vx, vy, vz, vn = motion.target_rate
        ax, ay, az, an = motion.target_acceleration
        qx, qy, qz, qn = abs(vx) * vx, abs(vy) * vy, abs(vz) * vz, abs(vn) * vn
        sx, sy, sz, sn = composite_error(motion, self.params.error_rate_ps)
        kx, ky, kz, kn = self.params.error_gain
        x = ax * state[0] + qx * state[1] - kx * sx
        y = ay * state[2] + qy * state[3] - ky * sy
        z = az * state[4] + qz * state[5] - kz * sz
        n = an * state[6] + qn * state[7] - kn * sn
        if self.params.frame == "body":
            x, y = motion.cosine * x + motion.sine * y, motion.cosine * y - motion.sine * x
        return (x, y, z, n), (ax * sx, qx * sx, ay * sy, qy * sy, az * sz, qz * sz, an * sn, qn * sn)

    def _virtual(self, state: State, motion: Motion) -> tuple[Vec4, Rates]:
        """Return tau of (3.10) and Y^T s in the body frame, with the virtual reference."""
        nu, nu_r, nu_r_rate = virtual_motion(motion, self.params.error_rate_ps)
        s1, s2, s3, s4 = s = (nu[0] - nu_r[0], nu[1] - nu_r[1], nu[2] - nu_r[2], nu[3] - nu_r[3])
        x, y, z, n = body_forces(state, nu, nu_r, nu_r_rate)
        k1, k2, k3, k4 = self.params.error_gain
        tau = (x - k1 * s1, y - k2 * s2, z - k3 * s3, n - k4 * s4)
        return tau, transposed_times(nu, nu_r, nu_r_rate, s)

    def _motion(self, state: State, view: MotionView) -> Motion:
        """Return the vehicle's motion and its path point, with the blend of the start."""
        p, start = self.params, state[self._count :]
        return motion_of(view, _path(view), is_flat=p.frame == "flat", start=start, blend_s=p.blend_s)

    def _estimate_energy(self, state: State, indices: Iterable[int]) -> float:
        """Return a~^T GAM^-1 a~ / 2 over the adapted ones of the estimates (J), thesis Eq. (3.23)."""
        return 0.5 * sum(
            (state[i] - self._nominal[i]) ** 2 / self._gains[i] for i in indices if self._gains[i] > 0.0
        )

    def _ordered(self, inertia: Vec4, linear: Vec4, quadratic: Vec4) -> tuple[float, ...]:
        """Return three four-vectors in the order of the estimates."""
        if self._is_thesis:
            return tuple(x for pair in zip(inertia, quadratic, strict=True) for x in pair)
        return (*inertia, *linear, *quadratic)

    def _boxed(self, estimates: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(
            [
                low if a < low else high if a > high else a
                for a, low, high in zip(estimates, self._low, self._high, strict=True)
            ]
        )


def _path(view: MotionView) -> PathPoint:
    if view.path is None:
        raise ValueError(
            "adaptive: a view without a path is not allowed; allowed: a view of a vehicle with a reference"
        )
    return view.path


def _six(s: Vec4) -> Vec6:
    return (s[0], s[1], s[2], 0.0, 0.0, s[3])


def _clipped(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
