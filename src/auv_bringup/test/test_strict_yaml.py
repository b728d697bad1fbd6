"""Claims about the YAML of scenarios: numbers are decimal or refused, and no text takes long."""

import math
import os
import time

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from auv_bringup.launching.plan import make_plan
from auv_core.params import ConfigError
from auv_experiment.scenario.file import SCENARIOS_DIR
from auv_experiment.scenario.loading import load_scenario
from auv_experiment.scenario.strict_yaml import MOST_BYTES, MOST_VALUES, parse_yaml, to_yaml

SIGNS = st.sampled_from(["", "-", "+"])
DIGITS = st.text("0123456789", min_size=1, max_size=9)
LONGEST_S = 20.0
"""Far above what a refusal takes, far below what a bomb took."""


@given(SIGNS, DIGITS)
def test_a_word_of_digits_is_the_decimal_number_that_it_looks_like(sign, digits):
    assert parse_yaml(sign + digits, "x") == int(sign + digits)


@given(SIGNS, st.text("0123456789", max_size=5), st.text("0123456789", max_size=5), SIGNS, DIGITS)
def test_a_word_with_a_point_or_an_exponent_is_the_number_that_it_looks_like(
    sign, whole, rest, power, digits
):
    for text in (f"{sign}{whole}.{rest}", f"{sign}{whole}.{rest}e{power}{digits[:2]}"):
        if whole or rest:
            assert parse_yaml(text, "x") == float(text)


@given(st.text("0123456789+-._:xoeEabf", min_size=1, max_size=8))
def test_a_number_is_never_another_one_than_python_reads_in_decimal(text):
    try:
        value = parse_yaml(text, "x")
    except ConfigError:
        return
    if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value):
        assert "_" not in text
        assert value == float(text)


@pytest.mark.parametrize(
    "text", ["10:00", "1:30:00", "190:20:30.15", "0x10", "0b11", "0o17", "1_000", "6_0.0"]
)
def test_other_notations_are_words(text):
    assert parse_yaml(text, "x") == text
    with pytest.raises(ConfigError, match=r"duration_s: '.*' is not allowed; allowed: a finite number"):
        load_scenario("flock_acoustic", overrides=[f"duration_s={text}"])


@pytest.mark.parametrize("text", ["!!int 0x10", "!!int 1_0", "!!float 1:30", "!!float 1_0.0", "!!int 10:00"])
def test_an_explicit_type_does_not_bring_them_back(text):
    with pytest.raises(ConfigError, match="a value that does not fit its type"):
        parse_yaml(text, "x")


def test_overrides_and_files_read_numbers_alike(tmp_path):
    text = (SCENARIOS_DIR / "flock_acoustic.yaml").read_text()
    path = tmp_path / "mine.yaml"
    path.write_text(
        text.replace("centre_ned_m: [0.0, 10.0, 10.0]", "centre_ned_m: [-.5, 010, 010]") + "\nseed: 010\n"
    )
    by_file = load_scenario(str(path))
    by_override = load_scenario(
        "flock_acoustic", overrides=["seed=010", "random_starts.centre_ned_m=[-.5, 010, 010]"]
    )
    assert by_file.seed == by_override.seed == 10
    assert by_file.random_starts == by_override.random_starts
    assert by_file.random_starts is not None
    assert by_file.random_starts.centre_ned_m == (-0.5, 10.0, 10.0)


@example("\x85")
@example("a\u2028: b")
@given(st.text(max_size=12) | st.text("0123456789+-._:xoeE~", max_size=8) | st.floats() | st.integers())
def test_what_is_written_reads_back_here_and_elsewhere(value):
    def same(read):
        return read == value or (value != value and read != read)

    text = to_yaml({"x": value})
    assert same(parse_yaml(text, "x")["x"])
    assert same(yaml.safe_load(text)["x"])


BOMBS = {
    "merge keys": "a0: &a0 {x: 1}\n"
    + "".join(f"a{i}: &a{i} {{<<: [*a{i - 1}, *a{i - 1}], k{i}: 1}}\n" for i in range(1, 60)),
    "aliases": "a0: &a0 [1, 2]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]\n" for i in range(1, 60)),
    "an alias inside itself": "a: &a [*a]",
    "many keys": "".join(f"k{i}: 1\n" for i in range(60_000)),
}


@pytest.mark.parametrize("name", BOMBS)
def test_a_bomb_is_refused_in_one_line_soon(name, tmp_path):
    path = tmp_path / "bomb.yaml"
    path.write_text(BOMBS[name])
    before_s = time.process_time()
    with pytest.raises(
        ConfigError, match=f"^scenario: too large; allowed: at most {MOST_VALUES:,} values"
    ) as refusal:
        load_scenario(str(path))
    assert time.process_time() - before_s < LONGEST_S
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("source", ["file", "endless"])
def test_a_long_text_is_refused_before_it_is_read_whole(source, tmp_path):
    path = "/dev/zero"
    if source == "file":
        path = tmp_path / "long.yaml"
        path.write_text("#" * (MOST_BYTES + 1))
    with pytest.raises(ConfigError, match=f"too long; allowed: a YAML file of at most {MOST_BYTES:,} bytes"):
        load_scenario(str(path))


def test_a_bomb_in_an_override_is_refused_too():
    text = BOMBS["aliases"].replace("\n", ", ").rstrip(", ")
    with pytest.raises(ConfigError, match="--set agent: too large"):
        load_scenario("flock_acoustic", overrides=[f"agent={{{text}}}"])


@pytest.mark.parametrize("mode", ["inprocess", "lockstep"])
def test_a_scenario_may_come_through_a_pipe(mode):
    """A continuous scenario that is flown sampled was read twice, the second time from an empty pipe."""
    reader, writer = os.pipe()
    os.write(writer, (SCENARIOS_DIR / "ch5_one_leader.yaml").read_bytes())  # less than a pipe holds
    os.close(writer)
    try:
        plan = make_plan(f"/dev/fd/{reader}", mode=mode)
    finally:
        os.close(reader)
    assert plan.scenario.name == "ch5_one_leader"
    assert plan.is_switched == (mode == "lockstep")
    assert plan.scenario.sampling == ("sampled" if mode == "lockstep" else "continuous")
