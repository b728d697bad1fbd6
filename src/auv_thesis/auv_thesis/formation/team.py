"""
A team of vehicles in formation in continuous time, with perfect information of each other.

Vehicle i holds slot i at the start. Each follows its desired motion

    eta_d,i = w_i + sum_j W_ij (eta_j - w_j)

with the law of chapter 3 (`auv_thesis.formation.law`); the path is one more vehicle with offset 0. The law is
evaluated in every stage of an RK4 step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from auv_control.formations.frame import Course
from auv_control.formations.references import Weights
from auv_control.start_blend import blend
from auv_thesis.formation.law import Floats, Law, acceleration, body_from_ned, ned_from_body, wrench

STEP_S = 0.1


class Leg(NamedTuple):
    """Path point (m, m/s, m/s^2; NED) and course at one instant."""

    position: Floats
    velocity: Floats
    acceleration: Floats
    course: Course


Path = Callable[[float], Leg]
Force = Callable[[float, Floats, Floats], Floats]


class Plan(NamedTuple):
    """
    Slots and references of a team from one instant on.

    before, after : (N, 3) arrays
        Offsets (m; frame of the formation), between which the vehicles move on a quintic.
    weights : Weights
        The references.
    start_s, duration_s : float
        When the motion begins and how long it lasts (s).

    """

    before: Floats
    after: Floats
    weights: Weights
    start_s: float = 0.0
    duration_s: float = 0.0

    def offsets(self, t_s: float) -> tuple[Floats, Floats, Floats]:
        """Return the offsets at a time, with their rates and accelerations."""
        left, rate_ps, rate_ps2 = blend(t_s - self.start_s, self.duration_s)
        step = self.before - self.after
        return self.after + left * step, rate_ps * step, rate_ps2 * step


def joined(plans: Sequence[Plan]) -> Plan:
    """
    Return a plan of several teams that fly along one path and know nothing of each other.

    It costs little more than a plan of one team. The vehicles are those of the teams, one after the other;
    when the motion begins and how long it lasts is that of the first plan.
    """
    weights = Weights(
        block_diag(*(plan.weights.others for plan in plans)),
        np.concatenate([plan.weights.path for plan in plans]),
    )
    before, after = (np.concatenate([plan[k] for plan in plans]) for k in (0, 1))
    return Plan(before, after, weights, plans[0].start_s, plans[0].duration_s)


def no_force(t_s: float, eta: Floats, nu: Floats) -> Floats:
    """Return no force, (N, 4)."""
    return np.zeros_like(eta)


@dataclass(frozen=True)
class Setting:
    """
    Conditions of a flight.

    plans : tuple of Plan
        The plans, by their start; the last that has begun counts.
    path : Path
        The path of the formation.
    duration_s : float
        Length of the flight (s).
    law : Law
        Law and plant.
    force : Force
        Disturbing force at a time on vehicles at eta with velocity nu (N, N m; NED).
    avoidance : Force
        Force that the vehicles add to that of the law (N; NED).
    start_m : (N, 3) array, optional
        Displacement of the vehicles from their slots at the start (m; NED).
    dead_from_s : mapping, optional
        Time from which a vehicle has no thrust, by index (s).
    tells_acceleration : bool
        Whether vehicles know the accelerations of those that they steer by, one stage old.
    max_force_n : float
        Limit of each force (N).

    """

    plans: tuple[Plan, ...]
    path: Path
    duration_s: float
    law: Law = field(default_factory=Law)
    force: Force = no_force
    avoidance: Force = no_force
    start_m: Floats | None = None
    dead_from_s: dict[int, float] = field(default_factory=dict)
    tells_acceleration: bool = False
    max_force_n: float = np.inf


class Flight(NamedTuple):
    """
    What a team did.

    t_s : (K + 1,) array
        Instants (s).
    positions, offsets : (K + 1, N, 3) arrays
        Positions and world offsets of the slots (m; NED).
    wanted : (K + 1, N, 3) array
        Desired positions (m; NED).
    path : (K + 1, 3) array
        Path points (m; NED).
    forces_n : (K + 1, N, 3) array
        Forces of the law (N; body).

    """

    t_s: Floats
    positions: Floats
    offsets: Floats
    wanted: Floats
    path: Floats
    forces_n: Floats


class _Aim(NamedTuple):
    """Desired motion of all vehicles, (N, 4) each, and the world offsets, (N, 3)."""

    motion: tuple[Floats, Floats, Floats]
    offsets: Floats


def world_offsets(plan: Plan, course: Course, t_s: float) -> tuple[Floats, Floats, Floats]:
    """Return w, w' and w'' of all slots, (N, 3) each; `formations.frame.world_offset` over arrays."""
    c, s = np.cos(course.chi_rad), np.sin(course.chi_rad)
    turn = np.array(((c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)))
    quarter = np.array(((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    w, dw, ddw = (rows @ turn for rows in plan.offsets(t_s))
    rate, change = course.rate_radps, course.acceleration_radps2
    across = w @ quarter
    flat = w * (1.0, 1.0, 0.0)
    return w, dw + rate * across, ddw + 2.0 * rate * dw @ quarter + change * across - rate * rate * flat


class _Team:
    """The equations of motion of a team; the state is (N, 20): eta, nu and the twelve estimates."""

    def __init__(self, setting: Setting) -> None:
        self.setting = setting
        self._accelerations = np.zeros((len(setting.plans[0].before), 3))

    def start(self) -> Floats:
        """Return the state at the start: in the slots, with the velocity of the slots."""
        law = self.setting.law
        leg, plan = self.setting.path(0.0), self.setting.plans[0]
        w, dw, _ = world_offsets(plan, leg.course, 0.0)
        count = len(w)
        place = leg.position + w + (0.0 if self.setting.start_m is None else self.setting.start_m)
        psi = np.full(count, leg.course.chi_rad)
        rates = np.column_stack((leg.velocity + dw, np.full(count, leg.course.rate_radps)))
        return np.column_stack((place, psi, body_from_ned(psi, rates), np.tile(law.estimates, (count, 1))))

    def aim(self, t_s: float, eta: Floats, nu: Floats) -> _Aim:
        """Return the desired motion."""
        leg = self.setting.path(t_s)
        first, *later = self.setting.plans
        plan = [first, *(each for each in later if each.start_s <= t_s)][-1]
        others, path = plan.weights
        w, dw, ddw = world_offsets(plan, leg.course, t_s)
        rates = ned_from_body(eta[:, 3], nu)[:, :3]
        place = w + others @ (eta[:, :3] - w) + np.outer(path, leg.position)
        rate = dw + others @ (rates - dw) + np.outer(path, leg.velocity)
        change = ddw + others @ (self._accelerations - ddw) + np.outer(path, leg.acceleration)
        if not self.setting.tells_acceleration:
            change = np.zeros_like(place)
        course = np.broadcast_to(leg.course, (len(eta), 3))
        motion = (
            np.column_stack((place, course[:, 0])),
            np.column_stack((rate, course[:, 1])),
            np.column_stack((change, course[:, 2])),
        )
        return _Aim(motion, w)

    def forces(self, t_s: float, state: Floats) -> tuple[Floats, Floats, _Aim]:
        """Return the forces of the law within their limit, Y^T s, and the aim."""
        eta, nu, estimates = state[:, :4], state[:, 4:8], state[:, 8:]
        aim = self.aim(t_s, eta, nu)
        tau, direction = wrench(self.setting.law, eta, nu, aim.motion, estimates)
        tau += body_from_ned(eta[:, 3], self.setting.avoidance(t_s, eta, nu))
        tau[:, :3] = np.clip(tau[:, :3], -self.setting.max_force_n, self.setting.max_force_n)
        for index, since_s in self.setting.dead_from_s.items():
            if t_s >= since_s:
                tau[index] = 0.0
        return tau, direction, aim

    def rates(self, t_s: float, state: Floats) -> Floats:
        """Return the rates of the state."""
        law, eta, nu = self.setting.law, state[:, :4], state[:, 4:8]
        tau, direction, _ = self.forces(t_s, state)
        push = body_from_ned(eta[:, 3], self.setting.force(t_s, eta, nu))
        nu_rate = acceleration(law, nu, tau + push)
        if self.setting.tells_acceleration:
            turning = nu_rate.copy()
            turning[:, 0] -= nu[:, 3] * nu[:, 1]
            turning[:, 1] += nu[:, 3] * nu[:, 0]
            self._accelerations = ned_from_body(eta[:, 3], turning)[:, :3]
        return np.concatenate((ned_from_body(eta[:, 3], nu), nu_rate, -law.adaptation * direction), axis=1)


def fly(setting: Setting) -> Flight:
    """Return the flight of a team in a setting."""
    team = _Team(setting)
    steps = round(setting.duration_s / STEP_S)
    state, h = team.start(), STEP_S
    rows = []
    for k in range(steps + 1):
        t_s = k * h
        tau, _, aim = team.forces(t_s, state)
        rows.append(
            (state[:, :3].copy(), aim.offsets, aim.motion[0][:, :3], setting.path(t_s).position, tau[:, :3])
        )
        k1 = team.rates(t_s, state)
        k2 = team.rates(t_s + 0.5 * h, state + 0.5 * h * k1)
        k3 = team.rates(t_s + 0.5 * h, state + 0.5 * h * k2)
        k4 = team.rates(t_s + h, state + h * k3)
        state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        if setting.law.adapts:
            state[:, 8:] = setting.law.boxed(state[:, 8:])
    times_s = np.arange(steps + 1, dtype=np.float64) * h
    return Flight(times_s, *(np.array(column) for column in zip(*rows, strict=True)))


def straight(speed_mps: float, step_mps: float = 0.0, step_at_s: float = np.inf) -> Path:
    """Return a path to the north whose speed changes by `step_mps` at a time (m/s, s)."""

    def at(t_s: float) -> Leg:
        after_s = max(0.0, t_s - step_at_s)
        north_m = speed_mps * t_s + step_mps * after_s if after_s else speed_mps * t_s
        now_mps = speed_mps + (step_mps if t_s >= step_at_s else 0.0)
        return Leg(np.array((north_m, 0.0, 0.0)), np.array((now_mps, 0.0, 0.0)), np.zeros(3), Course(0.0))

    return at


def circle(radius_m: float, rate_radps: float) -> Path:
    """Return a circle about the origin that turns right (m, rad/s)."""

    def at(t_s: float) -> Leg:
        angle = rate_radps * t_s
        c, s = np.cos(angle), np.sin(angle)
        speed = radius_m * rate_radps
        return Leg(
            np.array((radius_m * s, -radius_m * c, 0.0)),
            np.array((speed * c, speed * s, 0.0)),
            np.array((-speed * rate_radps * s, speed * rate_radps * c, 0.0)),
            Course(float(angle), rate_radps),
        )

    return at
