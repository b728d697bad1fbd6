"""Claims about the strict loader: what it refuses, what it says, and that `dump` is its inverse."""

import math
from dataclasses import dataclass

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.params import ConfigError, Section, dump, extended, load, load_section, param, same

MODELS = "auv_core.models"


@dataclass(frozen=True)
class Wheel:
    radius_m: float = param("radius (m)", above=0.0, maximum=2.0)
    spare: bool = param("whether it is a spare", default=False)


@dataclass(frozen=True)
class Cart:
    seats: int = param("number of seats", minimum=1, maximum=9)
    number: int = param("number plate", default=0, minimum=0, maximum=2**31 - 1)
    load_ratio: float = param("how full it is", default=0.5, minimum=0.0, maximum=1.0)
    gear: str = param("gear", default="slow", choices=("slow", "fast"))
    name: str = param("what people call it", default="")
    centre_m: tuple[float, float, float] = param("centre (m; NED)", default=(0.0, 0.0, 0.0))
    tags: tuple[str, ...] = param("words", default=())
    wheels: tuple[Wheel, ...] = param("wheels", default=())
    spare: Wheel | None = param("one more wheel", default=None)
    model: Section | None = param("its motion", default=None, plugins=MODELS)

    def __post_init__(self):
        if len(self.wheels) > 4:
            raise ValueError(f"wheels: {len(self.wheels)} is not allowed; allowed: at most 4")


NOT_CARTS = [
    ({}, "cart.seats: missing; it is number of seats"),
    ({"sets": 2}, "cart: unknown key 'sets'; allowed: [seats, number, load_ratio"),
    ({7: 2}, "cart: unknown key 7;"),
    ({10**6000: 2}, "cart: unknown key"),
    ([1], "cart: [1] is not allowed; allowed: a mapping with the keys [seats"),
    (None, "cart: None is not allowed; allowed: a mapping"),
]

WORD, WHOLE, FINITE = "allowed: a word", "allowed: a whole number", "allowed: a finite number"
A_MODEL, A_MAPPING = (
    "allowed: four_dof, kinematic, six_dof, torpedo, torpedo_coefficients",
    "allowed: a mapping",
)

REFUSED = [
    ("seats", 2.0, ": 2.0", f"{WHOLE} at least 1 and at most 9"),
    ("seats", True, ": True", WHOLE),
    ("seats", "2", ": '2'", WHOLE),
    ("seats", 0, ": 0", f"{WHOLE} at least 1 and at most 9"),
    ("seats", 10, ": 10", f"{WHOLE} at least 1 and at most 9"),
    ("number", -1, ": -1", f"{WHOLE} at least 0 and at most 2147483647"),
    ("seats", 10**30, ": 1000", f"{WHOLE} at least 1 and at most 9"),
    ("seats", 10**6000, ": a number too long to print", f"{WHOLE} at least 1 and at most 9"),
    ("name", 10**6000, ": a number too long to print", WORD),
    ("load_ratio", 1.5, ": 1.5", f"{FINITE} at least 0 and at most 1"),
    ("load_ratio", -1e-9, ": -1e-09", FINITE),
    ("load_ratio", math.nan, ": nan", FINITE),
    ("load_ratio", math.inf, ": inf", FINITE),
    ("load_ratio", 10**400, "", FINITE),
    ("load_ratio", False, ": False", FINITE),
    ("load_ratio", "0.5", ": '0.5'", FINITE),
    ("load_ratio", None, ": None", FINITE),
    ("gear", "back", ": 'back'", "allowed: slow, fast"),
    ("gear", 1, ": 1", WORD),
    ("gear", True, ": True", WORD),
    ("centre_m", [1, 2], ": [1, 2]", "allowed: a list of 3 numbers"),
    ("centre_m", 5, ": 5", "allowed: a list of 3 numbers"),
    ("centre_m", "abc", ": 'abc'", "allowed: a list of 3 numbers"),
    ("centre_m", [0, 0, math.nan], "[2]: nan", FINITE),
    ("tags", ["a", 3], "[1]: 3", WORD),
    ("tags", {"a": 1}, ": {'a': 1}", "allowed: a list"),
    ("wheels", [{"radius_m": 0}], "[0].radius_m: 0.0", f"{FINITE} above 0 and at most 2"),
    ("wheels", [{"radius_m": 1, "spare": 1}], "[0].spare: 1", "allowed: true or false"),
    ("wheels", [{"radius_m": 1}] * 5, ": 5", "allowed: at most 4"),
    ("model", "odin", ": 'odin'", A_MAPPING),
    ("model", {"kind": "boat"}, ".kind: 'boat'", A_MODEL),
    ("model", {"kind": "presets"}, ".kind: 'presets'", A_MODEL),
    ("model", {"kind": "../plugins"}, ".kind: '../plugins'", A_MODEL),
    ("model", {"kind": ["a"]}, ".kind: ['a']", A_MODEL),
    ("model", {"kind": 10**6000}, ".kind: a number too long to print", A_MODEL),
    ("model", {"kind": "kinematic", "params": 3}, ".params: 3", A_MAPPING),
    ("model", {"kind": "kinematic", "params": {"hull_radius_m": -1}}, ".params.hull_radius_m: -1.0", FINITE),
]

UNKNOWN_OR_MISSING = [
    ("wheels", [{}], "cart.wheels[0].radius_m: missing; it is radius (m)"),
    ("spare", {"radius": 1}, "cart.spare: unknown key 'radius'; allowed: [radius_m, spare]"),
    ("model", {}, "cart.model.kind: missing; it is the name of a file in auv_core.models"),
    ("model", {"kind": "kinematic", "parms": {}}, "cart.model: unknown key 'parms'; allowed: [kind, params]"),
]


def _refusal(raw):
    with pytest.raises(ConfigError) as refusal:
        load(Cart, raw, "cart")
    message = str(refusal.value)
    assert len(message.splitlines()) == 1
    return message


@pytest.mark.parametrize(("raw", "said"), NOT_CARTS, ids=[said for _, said in NOT_CARTS])
def test_what_is_no_cart_at_all_is_refused(raw, said):
    assert _refusal(raw).startswith(said)


@pytest.mark.parametrize(
    ("key", "value", "where_and_what", "allowed"), REFUSED, ids=[f"{row[0]}{row[2]}" for row in REFUSED]
)
def test_bad_values_are_refused_with_path_value_and_what_is_allowed(key, value, where_and_what, allowed):
    message = _refusal({"seats": 1, key: value})
    assert message.startswith(f"cart.{key}{where_and_what}")
    assert f"is not allowed; {allowed}" in message


@pytest.mark.parametrize(("key", "value", "said"), UNKNOWN_OR_MISSING)
def test_unknown_and_missing_keys_are_named_with_their_path(key, value, said):
    assert _refusal({"seats": 1, key: value}) == said


def test_message_is_one_short_line_for_long_values():
    assert len(_refusal({"seats": "line\n" * 1000})) < 200


def test_inconsistent_plugin_params_are_refused_with_their_path():
    raw = yaml.safe_load(
        """
        mass_kg: 100.0
        inertia_kgm2: [1.0, 1.0, 1.0]
        cog_z_m: 0.5
        added_mass: [0, 0, 0, 0, 0, 0]
        linear_damping: [0, 0, 0, 0, 0, 0]
        quadratic_damping: [0, 0, 0, 0, 0, 0]
        weight_n: 1.0
        buoyancy_n: 1.0
        max_wrench: [1, 1, 1, 1, 1, 1]
        hull_radius_m: 0.3
        """
    )
    with pytest.raises(ConfigError, match=r"^v\.params\.cog_z_m: 0\.5 is not allowed; allowed: .*definite"):
        load_section({"kind": "six_dof", "params": raw}, "v", MODELS)


def test_defaults_fill_what_is_left_out():
    assert load(Cart, {"seats": 3}, "cart") == Cart(seats=3)
    assert load_section({"kind": "kinematic"}, "model", MODELS) == load_section(
        {"kind": "kinematic", "params": None}, "model", MODELS
    )


def test_whole_numbers_are_taken_as_floats():
    cart = load(Cart, {"seats": 1, "load_ratio": 1}, "cart")
    assert type(cart.load_ratio) is float


def test_lists_become_tuples():
    cart = load(Cart, {"seats": 1, "tags": ["a"], "centre_m": [1, 2, 3]}, "cart")
    assert cart.tags == ("a",)
    assert cart.centre_m == (1.0, 2.0, 3.0)


WHEELS = st.builds(Wheel, radius_m=st.floats(1e-9, 2.0), spare=st.booleans())
COORDINATE = st.floats(-1e200, 1e200)
CARTS = st.builds(
    Cart,
    seats=st.integers(1, 9),
    load_ratio=st.floats(0.0, 1.0),
    gear=st.sampled_from(["slow", "fast"]),
    name=st.text(st.characters(codec="utf-8", categories=("L", "N", "P", "Z"))),
    centre_m=st.tuples(COORDINATE, COORDINATE, COORDINATE),
    tags=st.lists(st.sampled_from(["a", "b", ""]), max_size=3).map(tuple),
    wheels=st.lists(WHEELS, max_size=4).map(tuple),
    spare=st.none() | WHEELS,
    model=st.none()
    | st.floats(1e-6, 9.0).map(
        lambda r: load_section({"kind": "kinematic", "params": {"hull_radius_m": r}}, "model", MODELS)
    ),
)


@settings(max_examples=80, deadline=None)
@given(CARTS)
def test_load_is_the_inverse_of_dump_also_through_yaml(cart):
    assert load(Cart, dump(cart), "cart") == cart
    assert load(Cart, yaml.safe_load(yaml.safe_dump(dump(cart), allow_unicode=True)), "cart") == cart


PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=8,
)


@settings(max_examples=150, deadline=None)
@given(st.dictionaries(st.sampled_from([*Cart.__dataclass_fields__, "other"]), PLAIN))
def test_nothing_but_a_config_error_leaves_the_loader(raw):
    message = ""
    try:
        assert isinstance(load(Cart, raw, "cart"), Cart)
    except ConfigError as refusal:
        message = str(refusal)
    assert len(message.splitlines()) <= 1


def test_dump_of_a_section_is_kind_and_params():
    section = load_section({"kind": "kinematic", "params": {"hull_radius_m": 0.25}}, "model", MODELS)
    assert dump(section) == {"kind": "kinematic", "params": {"hull_radius_m": 0.25}}


@dataclass(frozen=True, kw_only=True)
class Sledge:
    seats: int = same(Cart, "seats", maximum=2)
    gear: str = same(Cart, "gear")
    runner_m: float = param("length of a runner (m)", above=0.0)


def test_a_field_of_another_configuration_keeps_what_is_not_changed() -> None:
    assert load(Sledge, {"seats": 2, "runner_m": 1.0}, "sledge") == Sledge(seats=2, gear="slow", runner_m=1.0)
    with pytest.raises(ConfigError, match=r"^sledge\.seats: 3 is not allowed; allowed: .* at most 2$"):
        load(Sledge, {"seats": 3, "runner_m": 1.0}, "sledge")
    with pytest.raises(ConfigError, match=r"^sledge\.gear: 'none' is not allowed; allowed: slow, fast$"):
        load(Sledge, {"seats": 1, "gear": "none", "runner_m": 1.0}, "sledge")


def test_a_configuration_takes_from_sections_the_fields_that_it_has_too() -> None:
    cart = Cart(seats=2, gear="fast", name="red")
    assert extended(Sledge, cart, runner_m=1.5) == Sledge(seats=2, gear="fast", runner_m=1.5)
    assert extended(Sledge, cart, runner_m=1.5, seats=1).seats == 1
