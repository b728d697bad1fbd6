"""Claims about vehicles with agents of their own: how sections combine, what is refused, what they hear."""

import re
from pathlib import Path

import numpy as np
import pytest

import auv_bringup
import auv_experiment
import shoal
from auv_core.messages import Inbox, Packet, Reception, VehicleState
from auv_core.params import ConfigError
from auv_experiment.compose import agent_configs
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.distances import pair_distances_m
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import (
    load_scenario,
    scenario_from_json,
    scenario_to_json,
    scenario_to_yaml,
)
from auv_experiment.scenario.teams import agent_key, distinct_agents, of_team, teams
from auv_experiment.team_runs import team_runs
from auv_flocking.agent import Agent
from auv_flocking.agent_config import report_format
from auv_flocking.fleets.lanes import Fleet
from auv_flocking.flock_task import FlockTask
from auv_flocking.lanes.status import STRAIGHT_ON, LaneStatus, Mode
from auv_flocking.report import Report


@pytest.fixture(scope="module")
def mixed():
    return load_scenario("mixed_fleet")


@pytest.fixture(scope="module")
def flown(mixed):
    scenario = load_scenario("mixed_fleet", duration_s=16.0, overrides=["acoustics.outage={kind: none}"])
    return scenario, run_in_process(scenario)


def _refusal(*overrides, name="mixed_fleet"):
    with pytest.raises(ConfigError) as caught:
        load_scenario(name, overrides=overrides)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_a_vehicle_takes_from_the_common_section_what_its_own_leaves_out(mixed):
    hovering, torpedo = mixed.agents[0], mixed.agents[1]
    assert torpedo is mixed.agent
    assert hovering.report.kind == "compact"
    assert hovering.neighbours.timeout_s == torpedo.neighbours.timeout_s == 900.0
    assert hovering.fleet is None  # a task that its controller has no use for
    assert hovering.flocking.kind == "communication_aware"  # as in a scenario that names no law


def test_one_vehicle_of_a_flock_has_its_own_gains():
    overrides = ["vehicles.3.agent={controller: {params: {position_gain: 1.0}}}"]
    message = _refusal(*overrides, name="flock_acoustic")
    assert message.startswith("scenario.vehicles[3].agent.controller.params: unknown key 'position_gain'")
    overrides = ["vehicles.3.model={preset: bluerov2_heavy}"]
    overrides += ["vehicles.3.agent={controller: {preset: velocity_pi_bluerov2_heavy}}", "agent.hold_s=5"]
    scenario = load_scenario("flock_acoustic", overrides=overrides)
    gains = [agent.controller.params.gains for agent in scenario.agents]
    assert gains[0] == gains[2] != gains[3]
    assert scenario.agents[3].flocking == scenario.agent.flocking
    assert scenario.agents[3].hold_s == 5.0
    assert teams(scenario) == [(0, 1, 2, 3)]
    assert [config.group for config in agent_configs(scenario)] == [()] * 4


def test_an_override_reaches_the_agent_of_one_vehicle():
    scenario = load_scenario("mixed_fleet", overrides=["vehicles.0.agent.clearance_m=11"])
    assert [agent.clearance_m for agent in scenario.agents] == [11.0, 8.0, 8.0, 8.0]


def test_a_scenario_with_agents_of_vehicles_is_written_and_read_again(mixed, tmp_path):
    assert scenario_from_json(scenario_to_json(mixed)) == mixed
    path = tmp_path / "again.yaml"
    path.write_text(scenario_to_yaml(mixed))
    assert load_scenario(str(path)) == mixed


def test_teams_are_what_acts_together(mixed):
    assert teams(mixed) == [(0,), (1, 2, 3)]
    assert [software.key for software in distinct_agents(mixed)] == ["vehicles[0].agent", "agent"]
    assert [agent_key(mixed, index) for index in range(4)] == ["vehicles[0].agent", *["agent"] * 3]
    alone = of_team(mixed, (0,))
    assert alone.agent == mixed.agents[0]
    assert alone.leaders == ("auv_1",)
    assert alone.reference == mixed.vehicles[0].reference


def test_agents_know_their_group_and_what_the_others_speak(mixed):
    configs = agent_configs(mixed)
    assert [config.group for config in configs] == [(1,), *[(2, 3, 4)] * 3]
    heard = [[spoken.report.kind for spoken in config.heard_reports] for config in configs]
    assert heard == [["lane"], *[["compact"]] * 3]
    agents = [Agent(config) for config in configs]
    assert [type(agent.task) for agent in agents] == [FlockTask, Fleet, Fleet, Fleet]
    assert [agent.command for agent in agents] == ["wrench", "fins", "fins", "fins"]
    assert len({agent.task.layer_m for agent in agents if isinstance(agent.task, Fleet)}) == 3


def test_a_fleet_with_one_agent_has_no_groups_and_reads_one_format():
    for name in ("torpedo_fleet", "flock_modem"):
        for config in agent_configs(load_scenario(name)):
            assert (config.group, config.heard_reports) == ((), ())


def test_every_vehicle_decodes_the_reports_of_all_others(flown):
    _, recording = flown
    knows = np.isfinite(recording.neighbour_age_s[-1])
    assert knows.sum() == 4 * 3
    off_m = recording.neighbour_position_ned_m[-1] - recording.position_ned_m[-2]
    assert np.nanmax(np.linalg.norm(off_m, axis=-1)) < 8.0
    assert (recording.holding == 0).all()


@pytest.mark.parametrize(("north_m", "gives_way"), [(157.0, True), (165.0, False)])
def test_a_hovering_vehicle_keeps_clear_of_a_torpedo_that_comes_near(mixed, north_m, gives_way):
    hovering, torpedo = agent_configs(mixed)[:2]
    agent, form = Agent(hovering), report_format(torpedo, 4)
    status = LaneStatus(0.0, 0.0, 0.0, Mode.TRANSIT, False, STRAIGHT_ON, 30.0).numbers()
    place, t_s = (north_m, 30.0, 30.0), 100.0
    sent = Report(2, t_s, place, (-1.5, 0.0, 0.0), place, (0.0, 0.0, 0.0), shared=status)
    packet = Packet(500, 2, 0, 1, form.encode(sent))
    nav = VehicleState(500, (150.0, 30.0, 30.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    agent.step(t_s, nav, Inbox(500, False, (Reception(packet, t_s, t_s, 0.0),), ()))
    assert agent.holding == ""
    assert (agent.reference.velocity[0] < -0.1) == gives_way


def test_metrics_and_parts_of_a_run_are_those_of_its_teams(flown):
    scenario, recording = flown
    alone, fleet = team_runs(recording, scenario)
    assert alone.recording.vehicle_ids == ("auv_1",)
    np.testing.assert_array_equal(fleet.recording.position_ned_m, recording.position_ned_m[:, 1:])
    assert set(fleet.recording.sent[:, 1]) == {1, 2, 3}
    assert len(fleet.recording.received) < len(recording.received)
    metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)
    assert metrics["pair_distance_min_m"] == pytest.approx(pair_distances_m(recording).min())
    assert metrics["turn_away_ratio"] == 0.0
    assert metrics["centroid_path_rms_m"] is None  # it counts later
    assert metrics["vehicles"] == 4


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("vehicles.0.agent=3", "vehicles[0].agent: 3 is not allowed; allowed: a mapping with the keys"),
        ("vehicles.0.agent.wings=1", "vehicles[0].agent: unknown key 'wings'"),
        (
            "vehicles.0.agent.controller={kind: autopilot}",
            "vehicles[0].reference: 'line' is not allowed",
        ),
        ("vehicles.1.agent={hold_s: 3}", "vehicles[1].agent.hold_s: 3.0 is not allowed; allowed: 0"),
        (
            "vehicles.1.agent={controller: {kind: velocity_pi}}",
            "reference: missing; allowed: a section",
        ),
        (
            "vehicles.1.agent={course: {kind: steps}}",
            "agent.report.kind: 'lane' is not allowed; allowed: another kind",
        ),
        (
            "vehicles.1.agent={fleet: {params: {speed_mps: 0.9}}}",
            "vehicles[1].agent.fleet.params.lane: 0",
        ),
        ("leaders=[auv_2]", "leaders[0]: 'auv_2' is not allowed; allowed: a vehicle that flocks"),
        ("sampling=continuous", "sampling: 'continuous' is not allowed"),
    ],
)
def test_what_does_not_fit_together_is_refused_in_one_line(override, words):
    message = _refusal(override)
    assert message.startswith(f"scenario.{words}"), message


def test_only_what_is_given_one_team_asks_a_scenario_for_its_one_agent():
    packages = [Path(package.__file__ or "").parent for package in (auv_experiment, auv_bringup, shoal)]
    one_team = {"metrics", "figures", "report", "inprocess", "courses", "formations"}
    asks = {
        path.name
        for package in packages
        for path in package.rglob("*.py")
        if path.parent.name not in one_team
        and re.search(r"(?<![\"'])scenario\.(agent|follows)\b", path.read_text(encoding="utf-8"))
    }
    assert asks == {"team_runs.py"}  # of the scenario of a team


DRAWN = "vehicles.3={id: auv_4, model: {preset: remus100}}"
DISC = "random_starts={centre_ned_m: [100.0, 0.0, 30.0], radius_m: 100.0, separation_m: 40.0, depths: layers}"


def test_a_random_start_of_a_vehicle_that_cannot_stop_is_in_its_layer_and_under_way():
    drawn = load_scenario("mixed_fleet", overrides=[DRAWN, DISC, "random_starts.speed_mps=1.2"]).vehicles[3]
    assert drawn.position_ned_m is not None
    assert (drawn.position_ned_m[2], drawn.speed_mps) == (42.0, 1.2)
    assert drawn.heading_rad != 0.0
    own = load_scenario("mixed_fleet", overrides=[DRAWN, DISC, "vehicles.3.speed_mps=1.4"]).vehicles[3]
    assert (own.position_ned_m, own.speed_mps, own.heading_rad) == (drawn.position_ned_m, 1.4, 0.0)


def test_a_random_start_of_one_that_can_stop_is_at_rest_and_where_none_has_a_layer():
    hovering = "vehicles.0.position_ned_m=null"
    drawn = load_scenario("mixed_fleet", overrides=[hovering, DISC]).vehicles[0]
    assert drawn.position_ned_m is not None
    assert (drawn.position_ned_m[2], drawn.speed_mps, drawn.heading_rad) == (30.0, 0.0, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_all_pairs_keep_their_distance(seed):
    scenario = load_scenario("mixed_fleet", seed=seed)
    recording = run_in_process(scenario)
    metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)
    assert metrics["pair_distance_min_m"] > 5.0
    assert metrics["fleet_formed_at_s"] < 620.0
    assert metrics["coordination_error_p95_m"] < 1.0


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "keeps"), [("none", False), ("intent_vo", True)])
def test_a_torpedo_turns_away_from_one_that_hovers_on_its_way(kind, keeps):
    overrides = [
        "agent.fleet.params.layers=none",
        f"agent.fleet.params.turn_away.kind={kind}",
        "vehicles.0.position_ned_m=[170.0, -58.0, 30.0]",
        "vehicles.0.reference.params.start_ned_m=[170.0, -58.0, 30.0]",
        *(f"vehicles.{index}.position_ned_m.2=30.0" for index in (1, 2, 3)),
    ]
    recording = run_in_process(load_scenario("mixed_fleet", duration_s=60.0, overrides=overrides))
    assert (pair_distances_m(recording)[:, 1].min() > 13.0) == keeps
