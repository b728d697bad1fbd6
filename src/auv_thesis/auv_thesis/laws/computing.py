"""
Time that one evaluation of a law takes for one vehicle: the thesis's formation laws beside its flocking laws.

Every law runs as plain Python in the form in which the thesis integrates it: from poses, path and the others
to forces or velocities and the rates of its own state (`MotionLaw.evaluate`, `FlockTask.rates`). Each repeat
times all laws in turn, so that their ratio does not depend on how busy the machine is. The thesis's flocking
laws command a velocity; on a hull a velocity controller turns it into forces, as the formation laws do
themselves.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from auv_control.controllers import MotionView, VelocityReference, make_controller
from auv_control.references import PathPoint
from auv_core.geometry import Vec3
from auv_core.messages import VehicleState
from auv_experiment.recording import FloatArray
from auv_experiment.scenario.loading import load_scenario
from auv_flocking.consensus import make_consensus
from auv_flocking.flock_task import FlockTask
from auv_flocking.flocking import Member, make_flocking
from auv_flocking.separation import make_separation

SIZES = (3, 4, 8, 16, 32)
REPEATS = 20
_STEPS = 40
_PERIOD_S = 0.1
ADAPTIVE, REGION = "adaptive formation (3)", "steering to a region (4)"
MATHEMATICAL, FUZZY = "mathematical flocking (5)", "fuzzy flocking (6)"
ON_A_HULL = "mathematical flocking with velocity control of a hull"
LAWS = (ADAPTIVE, REGION, MATHEMATICAL, FUZZY, ON_A_HULL)
_LEVEL = (1.0, 0.0, 0.0, 0.0)
_NU = (0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
_ZERO: Vec3 = (0.0, 0.0, 0.0)
_PATH = PathPoint((0.5, 10.0, 10.0), (0.1, 0.0, 0.0))

Evaluate = Callable[[], object]


@cache
def times_us(n_vehicles: int) -> dict[str, FloatArray]:
    """Return the times of one evaluation for one of `n_vehicles` (REPEATS,) (microseconds), by law."""
    laws = _laws(n_vehicles)
    times = {name: np.empty(REPEATS) for name in laws}
    for repeat in range(REPEATS):
        for name, evaluate in laws.items():
            started_s = time.perf_counter()
            for _ in range(_STEPS):
                evaluate()
            times[name][repeat] = 1e6 * (time.perf_counter() - started_s) / _STEPS
    return times


def _laws(n_vehicles: int) -> dict[str, Evaluate]:
    """Return every law as a function for the first of vehicles that are 2 m apart on a circle."""
    radius_m = 1.0 / math.sin(math.pi / n_vehicles)
    turns = [2.0 * math.pi * i / n_vehicles for i in range(n_vehicles)]
    own, *others = [(radius_m * math.cos(turn), radius_m * math.sin(turn), 10.0) for turn in turns]
    mathematical = _flocking("ch5_four_leaders", n_vehicles, own, others)
    inner = _velocity_control(own)

    def on_a_hull() -> None:
        mathematical()
        inner()

    return {
        ADAPTIVE: _formation("ch3_circle", own, ()),
        REGION: _formation("ch4_region", own, tuple(others)),
        MATHEMATICAL: mathematical,
        FUZZY: _flocking("ch6_four_leaders", n_vehicles, own, others),
        ON_A_HULL: on_a_hull,
    }


def _formation(scenario: str, own: Vec3, others: tuple[Vec3, ...]) -> Evaluate:
    law: Any = make_controller(load_scenario(scenario).agent.controller, _PERIOD_S)
    view = MotionView(1.0, VehicleState(0, own, _LEVEL, _NU), _PATH, others)
    return partial(law.evaluate, law.initial_state(view), view)


def _flocking(scenario: str, n_vehicles: int, own: Vec3, others: list[Vec3]) -> Evaluate:
    agent: Any = load_scenario(scenario).agent
    law = make_flocking(agent.flocking, make_separation(agent.separation), Member(is_leader=True))
    controller: Any = make_controller(agent.controller, _PERIOD_S)
    task = FlockTask(
        law, make_consensus(agent.consensus, n_vehicles), controller, (), _PERIOD_S, is_leader=True
    )
    return partial(task.rates, _PATH, own, _ZERO, [(place, _ZERO) for place in others])


def _velocity_control(own: Vec3) -> Evaluate:
    controller: Any = make_controller(load_scenario("flock_acoustic").agent.controller, _PERIOD_S)
    return partial(controller.evaluate, _LEVEL, _NU, _ZERO, VelocityReference(own, 0.0))
