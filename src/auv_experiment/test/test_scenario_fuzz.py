"""Claim: for any content of a scenario file, the loader raises only a one-line ConfigError."""

import copy
import json

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from auv_core.params import ConfigError
from auv_experiment.scenario.file import SCENARIOS_DIR, read_raw
from auv_experiment.scenario.loading import load_scenario, scenario_to_yaml
from auv_experiment.scenario.schema import Scenario

RAW = {name: read_raw(SCENARIOS_DIR / f"{name}.yaml") for name in ("flock_acoustic", "ch5_obstacles")}
RESOLVED = {f"{name}, resolved": yaml.safe_load(scenario_to_yaml(load_scenario(name))) for name in RAW}
VALID = {**RAW, **RESOLVED}

FUZZ = settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])

NUMBERS = (
    st.sampled_from([0, -1, 1, 2, 1e-320, 1e-9, 0.1, 1e9, 1e200, 1e308, 10**30, -(10**400)]) | st.floats()
)
WORDS = st.sampled_from(
    [
        "",
        "odin",
        "point",
        "ideal",
        "lossy",
        "auv_1",
        "auv_9",
        "kind",
        "params",
        "six_dof",
        "kinematic",
        "tdma",
        "none",
    ]
)
SCALARS = st.none() | st.booleans() | NUMBERS | st.integers() | WORDS | st.text(max_size=6) | st.dates()
VALUES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(WORDS | st.text(max_size=3) | NUMBERS, inner, max_size=3)
    ),
    max_leaves=6,
)


def _places(value, path=()):
    """Return the path of every item of nested plain data."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    places = []
    for key, item in items:
        places += [(*path, key), *_places(item, (*path, key))]
    return places


@st.composite
def mutations(draw):
    """Return a valid scenario with one to three changes: an item deleted, replaced, swapped or added."""
    raw = copy.deepcopy(VALID[draw(st.sampled_from(sorted(VALID)))])
    for _ in range(draw(st.integers(1, 3))):
        places = _places(raw)
        if not places:
            break
        *path, last = draw(st.sampled_from(places))
        parent = raw
        for key in path:
            parent = parent[key]
        change = draw(st.sampled_from(["delete", "replace", "swap", "add"]))
        if change == "delete":
            del parent[last]
        elif change == "replace":
            parent[last] = draw(VALUES)
        elif change == "swap":
            parent[last] = copy.deepcopy(
                draw(st.sampled_from([*parent.values()] if isinstance(parent, dict) else parent))
            )
        elif isinstance(parent, dict):
            parent[draw(WORDS | st.text(max_size=3))] = draw(VALUES)
        else:
            parent.append(draw(VALUES))
    return raw


def _loads_or_is_refused(path):
    message = ""
    try:
        scenario = load_scenario(str(path))
    except ConfigError as refusal:
        message = str(refusal)
    else:
        assert isinstance(scenario, Scenario)
    assert len(message.splitlines()) <= 1
    message.encode("utf-8")


@FUZZ
@given(mutations())
def test_changed_scenarios_load_or_are_refused_in_one_line(tmp_path, raw):
    path = tmp_path / "fuzz.yaml"
    path.write_text(yaml.safe_dump(raw, allow_unicode=False), encoding="utf-8")
    _loads_or_is_refused(path)


@FUZZ
@given(st.text(max_size=80) | st.text("{}[]:,-?!&*#|>'\"%@` \n\tab01.~=<", max_size=40))
def test_arbitrary_text_is_refused_in_one_line(tmp_path, text):
    path = tmp_path / "fuzz.yaml"
    path.write_text(text, encoding="utf-8", errors="surrogatepass")
    _loads_or_is_refused(path)


@FUZZ
@given(
    st.sampled_from(sorted(RAW)),
    st.integers(0, 3000),
    st.text("{}[]:,-!&*# \n.0e9x~\"'", max_size=3),
    st.integers(0, 6),
)
def test_typing_errors_are_refused_in_one_line(tmp_path, name, where, typed, dropped):
    text = (SCENARIOS_DIR / f"{name}.yaml").read_text(encoding="utf-8")
    where %= len(text)
    path = tmp_path / "fuzz.yaml"
    path.write_text(text[:where] + typed + text[where + dropped :], encoding="utf-8")
    _loads_or_is_refused(path)


@FUZZ
@given(
    st.lists(
        st.sampled_from([".".join(map(str, place)) for place in _places(RAW["flock_acoustic"])]), max_size=2
    ),
    st.text(max_size=4),
    VALUES.map(lambda value: yaml.safe_dump(value)) | st.text(max_size=8),
)
def test_overrides_load_or_are_refused_in_one_line(paths, more, value):
    message = ""
    try:
        load_scenario("flock_acoustic", overrides=[f"{path}{more}={value}" for path in paths])
    except ConfigError as refusal:
        message = str(refusal)
    assert len(message.splitlines()) <= 1


@pytest.mark.parametrize("name", sorted(VALID))
def test_the_scenarios_that_are_changed_are_valid(name, tmp_path):
    path = tmp_path / "valid.yaml"
    path.write_text(json.dumps(VALID[name]), encoding="utf-8")
    assert isinstance(load_scenario(str(path)), Scenario)
