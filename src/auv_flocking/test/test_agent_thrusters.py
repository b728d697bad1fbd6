"""Claims about the agent of a vehicle with thrusters: it allocates what its controller asks for."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
import yaml

import auv_core.models
from auv_control.allocation import qp
from auv_core.messages import Inbox, ThrusterCommand, VehicleState, Wrench
from auv_core.params import Section, dump, load
from auv_core.thrusters import Thrusters
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig

FAULT = {"thruster": 3, "t_s": 1.0, "known_after_s": 0.5}


def _thrusters():
    path = Path(str(auv_core.models.__file__)).parent / "presets/odin.yaml"
    return load(Thrusters, yaml.safe_load(path.read_text(encoding="utf-8"))["params"]["thrusters"], "odin")


ODIN = _thrusters()


def _agent(**changes):
    raw = {
        "vehicle_id": "auv_1",
        "address": 1,
        "fleet_size": 1,
        "is_leader": True,
        "period_s": 0.1,
        "reference": {"kind": "circle"},
        "flocking": {"kind": "potential"},
        "separation": {"kind": "mathematical"},
        "consensus": {"kind": "thesis"},
        "controller": {"kind": "velocity_pi", "params": {"max_force_n": 30.0}},
    }
    return Agent(load(AgentConfig, {**raw, **changes}, "agent"))


def _reached(commands):
    """Return the forces at the end of each period."""
    kept, forces, reached = math.exp(-0.1 / ODIN.lag_s), np.zeros(ODIN.count), []
    for command in commands:
        forces = command.forces_n + kept * (forces - command.forces_n)
        reached.append(forces)
    return reached


def _commands(agent, ticks=30, **changes):
    nav = VehicleState(0, (1.0, 8.0, 10.5), (1.0, 0.0, 0.0, 0.0), (0.05, 0.0, 0.0, 0.0, 0.0, 0.0))
    steps = (
        agent.step(0.1 * tick, nav._replace(tick=tick, **changes), Inbox(tick, False, ()))
        for tick in range(ticks)
    )
    return [command for command, _ in steps]


@pytest.mark.parametrize("kind", ["qp", "pinv_clip", "pinv_scale"])
def test_its_forces_give_the_wrench_that_its_controller_asks_for(kind):
    agent = _agent(thrusters=dump(ODIN), allocation={"kind": kind})
    assert agent.command == "thrusters"
    driven, pushed = _commands(agent), _commands(_agent())
    assert all(isinstance(command, ThrusterCommand) for command in driven)
    for forces, command in zip(_reached(driven), pushed, strict=True):
        np.testing.assert_allclose(ODIN.matrix() @ forces, command.tau, atol=1e-3)


def test_without_an_assumed_lag_its_demands_are_the_allocated_forces():
    agent = _agent(thrusters={**dump(ODIN), "assumed_lag_s": 0.0})
    for driven, pushed in zip(_commands(agent), _commands(_agent()), strict=True):
        np.testing.assert_allclose(ODIN.matrix() @ driven.forces_n, pushed.tau, atol=1e-3)


def test_demands_that_lead_stay_within_the_limits():
    weak = {**dump(ODIN), "max_forward_n": [8.0], "max_backward_n": [5.0]}
    for command in _commands(_agent(thrusters=weak), ticks=10):
        assert all(-5.0 <= force <= 8.0 for force in command.forces_n)


def test_a_lost_thruster_is_left_out_as_soon_as_the_loss_is_known():
    commands = _commands(_agent(thrusters=dump(ODIN), fault=FAULT))
    assert [tick for tick, command in enumerate(commands) if command.forces_n[2] != 0.0] == [*range(15)]
    wrenches = [command.tau for command in _commands(_agent())]
    given = [ODIN.matrix((3,)) @ forces for forces in _reached(commands)]
    np.testing.assert_allclose(given[15:], wrenches[15:], atol=1e-3)


def test_the_safe_command_is_no_force():
    agent = _agent(thrusters=dump(ODIN))
    assert _commands(agent, ticks=2, is_valid=False) == [ThrusterCommand((0.0,) * 8)] * 2
    assert agent.holding


def test_a_law_without_a_finite_command_gets_the_safe_one():
    agent = _agent(thrusters=dump(ODIN), controller={"kind": "velocity_pi"})
    agent._act = lambda *_: Wrench((math.nan,) * 6)
    assert _commands(agent, ticks=1) == [ThrusterCommand((0.0,) * 8)]


def test_the_default_allocator_is_the_quadratic_program():
    (field,) = [field for field in dataclasses.fields(AgentConfig) if field.name == "allocation"]
    assert field.default == Section("qp", qp.Params())
