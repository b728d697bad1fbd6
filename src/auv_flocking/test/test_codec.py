"""Claims about bounded fields and their bits."""

import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from auv_flocking.codec import Field, Layout, field_table
from auv_flocking.report import ReportError

MODERATE = settings(max_examples=100, deadline=None)
SPEED = Field("speed_mps", -2.56, 2.55, 0.01)
ANGLE = Field("angle", 0.0, 360.0, 0.5, wraps=True)
FLAG = Field("flag", 0, 1, 1)


@st.composite
def fields(draw, name="x", wraps=None):
    """Draw a field whose resolution is a decimal or a power of two, with up to 38 bits."""
    resolution = draw(st.sampled_from([1.0, 0.5, 2.0**-20, 0.1, 0.02, 0.0025, 3.0]))
    lowest = draw(st.integers(-(2**38), 2**38))
    steps = draw(st.integers(2, 2**38))
    return Field(
        name,
        lowest * resolution,
        (lowest + steps) * resolution,
        resolution,
        draw(st.booleans() if wraps is None else wraps),
    )


LAYOUTS = st.integers(1, 12).flatmap(
    lambda count: st.tuples(*[fields(f"x{index}") for index in range(count)])
)


@MODERATE
@given(fields(wraps=st.just(False)), st.floats(0.0, 1.0))
def test_a_round_trip_costs_at_most_half_a_resolution(field, share):
    value = field.minimum + share * (field.maximum - field.minimum)
    layout = Layout([field])
    (back,) = layout.unpack(layout.pack([value]))
    assert abs(back - value) <= 0.5 * field.resolution + 4.0 * math.ulp(max(abs(value), abs(field.minimum)))
    assert layout.saturated == 0


@MODERATE
@given(fields(wraps=st.just(True)), st.integers(-5, 5), st.floats(0.0, 1.0))
def test_a_wrapped_round_trip_costs_half_a_resolution_modulo_the_range(field, turns, share):
    span = field.maximum - field.minimum
    value = field.minimum + (turns + share) * span
    layout = Layout([field])
    (back,) = layout.unpack(layout.pack([value]))
    assert field.minimum - field.resolution / 2 <= back < field.maximum
    slack = 1e-9 * (abs(field.minimum) + 10.0 * span)
    assert abs(math.remainder(back - value, span)) <= 0.5 * field.resolution + slack
    assert layout.saturated == 0


@MODERATE
@given(LAYOUTS, st.randoms(use_true_random=False))
def test_every_level_of_every_field_survives_and_bits_are_packed_without_gaps(fields, random):
    layout = Layout(fields)
    levels = [random.randrange(field.levels) for field in fields]
    values = [field.value(level) for field, level in zip(fields, levels, strict=True)]
    payload = layout.pack(values)
    assert [f.level(v) for f, v in zip(fields, layout.unpack(payload), strict=True)] == levels
    assert len(payload) == layout.payload_bytes == math.ceil(sum(field.bits for field in fields) / 8)
    assert layout.saturated == 0


@MODERATE
@given(fields(wraps=st.just(False)), st.floats(allow_nan=False))
def test_values_outside_saturate_at_the_nearer_bound_and_are_counted(field, value):
    layout = Layout([field])
    (back,) = layout.unpack(layout.pack([value]))
    assert back == field.rounded(value)
    half = 0.5 * field.resolution
    if value < field.minimum - 1.01 * half:
        assert (back, layout.saturated) == (field.value(0), 1)
    elif value > field.maximum + 1.01 * half:
        assert (back, layout.saturated) == (field.value(field.levels - 1), 1)
    else:
        assume(field.minimum - 0.99 * half < value < field.maximum + 0.99 * half)
        assert layout.saturated == 0


def test_bits_stand_where_the_layout_says():
    layout = Layout([FLAG, SPEED, ANGLE])
    assert [field.bits for field in layout.fields] == [1, 9, 10]
    assert (layout.bits, layout.payload_bytes) == (20, 3)
    word = 1 << 19 | 256 << 10 | 719
    assert layout.pack([1, 0.0, 359.5]) == (word << 4).to_bytes(3, "big")
    assert layout.pack([1, 0.0, 359.8]) == (1 << 19 | 256 << 10).__lshift__(4).to_bytes(3, "big")


def test_zero_stays_zero():
    layout = Layout([SPEED, Field("depth_m", -163.84, 1146.86, 0.02)])
    assert layout.unpack(layout.pack([0.0, 0.0])) == [0.0, 0.0]


def test_a_power_of_two_is_exact():
    field = Field("sum", -(2.0**15), 2.0**15, 2.0**-20, wraps=True)
    for value in (2.0**15 - 2.0**-20, -1234.5, 2.0**-20):
        assert field.value(field.level(value)) == value


def test_what_is_not_a_number_is_refused():
    with pytest.raises(ReportError, match="speed_mps: nan cannot be sent"):
        Layout([SPEED]).pack([math.nan])
    for value in (math.nan, math.inf, -math.inf):
        with pytest.raises(ReportError, match="angle"):
            Layout([ANGLE]).pack([value])


@pytest.mark.parametrize("value", [math.inf, -math.inf, 1e308, -1e308])
def test_the_largest_numbers_saturate(value):
    layout = Layout([SPEED])
    assert layout.unpack(layout.pack([value])) == [math.copysign(2.56, value) - (0.01 if value > 0 else 0.0)]
    assert layout.saturated == 1


@pytest.mark.parametrize("length", [0, 2, 4])
def test_another_length_is_refused(length):
    with pytest.raises(ReportError, match=f"has 3 bytes, this has {length}"):
        Layout([FLAG, SPEED, ANGLE]).unpack(bytes(length))


def test_bits_that_mean_nothing_are_refused():
    layout = Layout([FLAG, SPEED, ANGLE])
    with pytest.raises(ReportError, match="angle: 720 stands for no value"):
        layout.unpack((720 << 4).to_bytes(3, "big"))
    with pytest.raises(ReportError, match="padding"):
        layout.unpack(b"\0\0\1")


@pytest.mark.parametrize(
    ("minimum", "maximum", "resolution"),
    [
        (0.0, 1.0, 0.3),
        (0.05, 1.05, 0.1),
        (1.0, 0.0, 0.1),
        (0.0, 1.0, 0.0),
        (0.0, 1.0, -1.0),
        (0.0, math.inf, 1.0),
        (math.nan, 1.0, 1.0),
        (0.0, 1.0, 2.0**-60),
    ],
)
def test_fields_that_cannot_be_are_refused_in_one_line(minimum, maximum, resolution):
    with pytest.raises(ValueError, match=r"^depth_m: bounds .* are not allowed; allowed: ") as caught:
        Field("depth_m", minimum, maximum, resolution)
    assert "\n" not in str(caught.value)


def test_two_fields_of_one_name_are_refused():
    with pytest.raises(ValueError, match="'flag' twice is not allowed"):
        Layout([FLAG, SPEED, FLAG])


def test_a_wrong_number_of_values_is_an_error_of_the_caller():
    with pytest.raises(ValueError, match="zip"):
        Layout([FLAG, SPEED]).pack([1.0])


def test_the_table_says_what_a_field_can_hold():
    assert field_table([SPEED, ANGLE])[2:] == [
        "| `speed_mps` | 9 | -2.56 | 2.55 | 0.01 | 0.005 |",
        "| `angle` | 10 | 0 | wraps at 360 | 0.5 | 0.25 |",
    ]
