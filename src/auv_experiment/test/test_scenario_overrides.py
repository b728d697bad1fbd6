"""Claims about `--set path.to.key=value`."""

import pytest

from auv_core.params import ConfigError
from auv_experiment.scenario.loading import load_scenario, scenario_to_yaml


def _load(*overrides, name="flock_acoustic"):
    return load_scenario(name, overrides=overrides)


@pytest.mark.parametrize(
    ("override", "read"),
    [
        ("seed=5", lambda s: s.seed == 5),
        ("duration_s=20", lambda s: s.duration_s == 20.0),
        ("agent.hold_s=1.5", lambda s: s.agent.hold_s == 1.5),
        ("leaders=[auv_2, auv_3]", lambda s: s.leaders == ("auv_2", "auv_3")),
        ("leaders.0=auv_4", lambda s: s.leaders == ("auv_4",)),
        ("vehicles.1.heading_rad=1.0", lambda s: s.vehicles[1].heading_rad == 1.0),
        ("random_starts.centre_ned_m.2=12", lambda s: s.random_starts.centre_ned_m[2] == 12.0),
        ("environment.obstacles=[]", lambda s: s.environment.obstacles == ()),
        ("agent.neighbours.timeout_s=5", lambda s: s.agent.neighbours.timeout_s == 5.0),
        ("agent.flocking.params={spacing_m: 3}", lambda s: s.agent.flocking.params.spacing_m == 3.0),
        ("title=a=b", lambda s: s.title == "a=b"),
        ("agent.neighbours.acceleration_psd=1e-2", lambda s: s.agent.neighbours.acceleration_psd == 0.01),
    ],
)  # fmt: skip
def test_an_override_changes_the_value_at_its_path(override, read):
    assert read(_load(override))


def test_an_override_changes_nothing_else():
    plain, changed = (scenario_to_yaml(_load(*o)).splitlines() for o in ([], ["vehicles.1.heading_rad=1.0"]))
    differences = [(a, b) for a, b in zip(plain, changed, strict=True) if a != b]
    assert differences == [("  heading_rad: 0.0", "  heading_rad: 1.0")]


def test_the_last_of_two_overrides_wins():
    assert _load("seed=5", "seed=6").seed == 6


def test_an_override_changes_one_user_of_a_yaml_alias_only(tmp_path):
    text = scenario_to_yaml(_load(name="ch5_one_leader"))
    head, tail = text.split("vehicles:\n")
    _, tail = tail.split("leaders:")
    starts = ["[-8, 4, 2]", "[8, 2, 1]", "[-4, -8, 0]"]
    models = ["&hull {preset: point}", "*hull", "*hull"]
    vehicles = [
        f"- {{id: auv_{i + 1}, position_ned_m: {starts[i]}, model: {models[i]}}}\n" for i in range(3)
    ]  # fmt: skip
    path = tmp_path / "aliases.yaml"
    path.write_text(head + "vehicles:\n" + "".join(vehicles) + "leaders:" + tail)
    scenario = load_scenario(str(path), overrides=["vehicles.1.model.params.hull_radius_m=0.5"])
    assert [vehicle.model.params.hull_radius_m for vehicle in scenario.vehicles] == [0.3, 0.5, 0.3]


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("seed", "--set 'seed' is not allowed; allowed: path.to.key=value"),
        ("=5", "--set '=5' is not allowed; allowed: path.to.key=value"),
        ("a..b=5", "--set 'a..b=5' is not allowed; allowed: path.to.key=value"),
        ("a\nb=5", "--set 'a\\nb=5' is not allowed; allowed: path.to.key=value"),
        ("dt_s.deep=5", "--set dt_s.deep: dt_s has no keys; it is 0.02"),
        ("dt_s.very.deep=5", "--set dt_s.very: dt_s has no keys; it is 0.02"),
        ("vehicles.4.id=x", "--set vehicles.4: '4' is not allowed; allowed: a number from 0 to 3"),
        (
            "vehicles.first.id=x",
            "--set vehicles.first: 'first' is not allowed; allowed: a number from 0 to 3",
        ),
        ("vehicles.-1.id=x", "--set vehicles.-1: '-1' is not allowed; allowed: a number from 0 to 3"),
        (f"vehicles.{'1' * 5000}.id=x", "--set vehicles.1111"),
        ("seed=[1", "--set seed: not YAML: "),
        ("seed=!!int ''", "--set seed: not YAML: a value that does not fit its type"),
        ("no.such.key=1", "scenario: unknown key 'no'"),
    ],
)
def test_bad_overrides_are_refused_in_one_line(override, said):
    with pytest.raises(ConfigError) as refusal:
        _load(override)
    assert str(refusal.value).startswith(said)
    assert len(str(refusal.value).splitlines()) == 1


def test_an_index_into_an_empty_list_is_refused():
    with pytest.raises(
        ConfigError, match=r"--set leaders\.0: '0' is not allowed; allowed: nothing, the list is empty"
    ):
        _load("leaders=[]", "leaders.0=auv_1")
