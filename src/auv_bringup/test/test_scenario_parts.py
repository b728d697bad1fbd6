"""Claims about scenarios whose parts do not fit together: one line that names the part, at load."""

import pytest

from auv_bringup.launching.verdict import LOST
from auv_bringup.tools import run as cli
from auv_core.params import ConfigError
from auv_experiment.scenario.loading import load_scenario

REFUSED = [
    (
        "ch2_pfpd",
        ["agent.controller.params.frame=body"],
        "agent.controller.params.frame: 'body' is not",
    ),
    (
        "ch2_pfpd_corrected",
        ["agent.controller.params.frame=flat"],
        "agent.controller.params.frame: 'flat' is not",
    ),
    (
        "ch2_pfpd",
        ["leaders=[auv_1]"],
        "leaders: ['auv_1'] is not allowed; allowed: nothing, since",
    ),
    (
        "ch2_pfpd",
        ["agent.separation={kind: mathematical}"],
        "agent.separation: 'mathematical' is not allowed; allo",
    ),
    (
        "ch2_pfpd",
        ["reference=null"],
        "reference: missing; allowed: a section, since the controller pfpd follows a",
    ),
    (
        "ch2_pfpd",
        ["environment.navigation={kind: noisy}"],
        "sampling: 'continuous' is not allowed; allowed: sampl",
    ),
    (
        "ch2_pfpd_corrected",
        ["vehicles.0.model.params={max_force_n: 5.0}"],
        "reference: runs at 0.1 m/s through the water, which is not allowed; allowed: at most 0.0",
    ),
    (
        "flock_acoustic",
        ["reference.params.rate_radps=0.5"],
        "reference: runs at 5.05 m/s through the water, which is not allowed; allowed: at most 1.77 m/s",
    ),
    (
        "ch2_pfpd_obstacles",
        ["environment.obstacles.0.position_ned_m=[0.1, 0, 0]"],
        "environment.obstacles[0].position_ned_m: lies in the hull of vehicles[0]; allowed: a place",
    ),
    (
        "ch2_pfpd",
        ["agent.controller.params.position_gain=[100, 150]"],
        "agent.controller.params.position_gain: [1",
    ),
    (
        "ch2_pfpd",
        ["agent.controller.params.position_gain=[-1, 150, 0]"],
        "agent.controller.params.position_gain[0]",
    ),
    (
        "ch5_one_leader",
        ["readings=[{axis: x, time_s: 1}]"],
        "readings: not allowed; allowed: nothing, unless the",
    ),
    (
        "ch2_pfpd",
        ["readings=[{axis: q, time_s: 1}]"],
        "readings[0].axis: 'q' is not allowed; allowed: x, y, z",
    ),
]


@pytest.mark.parametrize(("name", "overrides", "said"), REFUSED, ids=[said[:40] for _, _, said in REFUSED])
def test_parts_that_do_not_fit_are_named(name, overrides, said):
    with pytest.raises(ConfigError) as refusal:
        load_scenario(name, overrides=overrides)
    assert str(refusal.value).startswith(f"scenario.{said}"), str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_preset_of_a_controller_is_filled_in_and_can_be_overridden():
    scenario = load_scenario("ch3_circle", overrides=["agent.controller.params.max_force_n=800"])
    assert scenario.agent.controller.kind == "adaptive"


def test_a_motion_that_diverges_ends_the_run_with_one_line_and_status_3(tmp_path, capsys):
    """Drag as the thesis prints it drives on a hull that goes backwards: so it does from east of its path."""
    overrides = ["--set", "vehicles.0.position_ned_m=[0, -15, 0]", "--no-figures", "--out", str(tmp_path)]
    assert cli.main(["ch2_pfpd", *overrides]) == 0
    overrides[1] = "vehicles.0.position_ned_m=[0, 30, 0]"
    assert cli.main(["ch2_pfpd", *overrides]) == LOST
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert said.startswith("error: auv_1: its motion has no finite solution after t = ")
