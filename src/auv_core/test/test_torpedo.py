"""
Claims about the torpedo with strips: its derived numbers and its manoeuvres.

The manoeuvres were computed with Fossen's published program of the same vehicle, its Euler step refined, and
with a prototype of these equations; the tolerances are those between the two.
"""

import math
from dataclasses import replace

import pytest
from torpedo_flights import STILL, angles_deg, flown, preset, remus

from auv_core.models import make_model
from auv_core.models.torpedo import body_of, mass_kg, natural_frequencies_radps, spheroid, water_of
from auv_core.params import ConfigError, load_section

DEPTH_M = 100.0
REST = remus().initial_state((0.0, 0.0, DEPTH_M), 0.0)
FIVE_DEG = math.radians(5.0)
UP_AND_TO_STARBOARD = [
    (0.0, (FIVE_DEG, -FIVE_DEG, 1525.0)),
    (50.0, (FIVE_DEG, 0.0, 1525.0)),
    (100.0, (0.0, 0.0, 1525.0)),
]


def from_start(state):
    """Return the position (m; NED) from the start."""
    return (state[0], state[1], state[2] - DEPTH_M)


def test_derived_numbers_of_the_hull():
    params = preset("remus100").params
    body, water, mass = body_of(params), water_of(params), mass_kg(params)
    added = spheroid(params.hull).added_mass(mass, params.hull.roll_added_ratio)
    assert mass == pytest.approx(31.0294, rel=1e-4)
    assert added[:3] == pytest.approx((0.83891, 29.4376, 29.4376), rel=1e-4)
    assert added[4:] == pytest.approx((3.42621, 3.42621), rel=1e-4)
    assert (body.pitch_kgm2, body.yaw_kgm2) == pytest.approx((7.46639, 7.45398), rel=1e-4)
    assert (water.damping_roll_nms, water.damping_pitch_nms) == pytest.approx((0.58852, 10.7873), rel=1e-4)
    assert (water.lift, water.drag) == pytest.approx((0.26600, 0.05596), rel=1e-4)
    assert natural_frequencies_radps(params) == pytest.approx((6.2067, 0.9030), rel=1e-4)


def test_speed_steps_of_the_propeller():
    commands = [(0.0, (0.0, 0.0, 1525.0)), (100.0, (0.0, 0.0, 800.0))]
    states = flown(remus(), REST, commands, (2.0, 5.0, 10.0, 20.0, 99.0, 105.0, 150.0, 199.0))
    speeds = [states[t_s][7] for t_s in (2.0, 5.0, 10.0, 20.0, 105.0, 150.0)]
    assert speeds == pytest.approx([1.5570, 2.5107, 2.5534, 2.5537, 1.3861, 1.3383], abs=0.002)
    norths = [states[t_s][0] for t_s in (10.0, 99.0, 199.0)]
    assert norths == pytest.approx([20.614, 247.888, 385.175], abs=0.02)
    assert angles_deg(states[99.0])[0] == pytest.approx(1.0188, abs=0.005)


@pytest.mark.parametrize(
    ("cross_flow", "expected"),
    [
        (
            "horizontal",
            {
                10.0: ((19.346, 3.966, -3.881), (2.224, 20.205, 31.287)),
                50.0: ((3.083, 71.634, -37.989), (2.222, 20.140, 184.652)),
                100.0: ((3.719, -9.119, -39.541), (1.956, -0.285, 364.724)),
            },
        ),
        (
            "both",
            {
                10.0: ((19.528, 3.976, -3.206), (2.195, 18.715, 30.945)),
                50.0: ((3.726, 71.796, -37.139), (2.221, 20.080, 184.263)),
                100.0: ((3.941, -8.962, -39.246), (1.956, -0.289, 364.399)),
            },
        ),
    ],
)
def test_open_loop_climb_and_turn(cross_flow, expected):
    states = flown(remus(cross_flow=cross_flow), REST, UP_AND_TO_STARBOARD, (10.0, 50.0, 100.0, 149.0))
    for t_s, (position_m, attitude_deg) in expected.items():
        assert from_start(states[t_s]) == pytest.approx(position_m, abs=0.02)
        turned = [
            (a - b + 180.0) % 360.0 - 180.0
            for a, b in zip(angles_deg(states[t_s]), attitude_deg, strict=True)
        ]
        assert turned == pytest.approx([0.0, 0.0, 0.0], abs=0.02)
    last_m = (128.195, 3.433, -39.534) if cross_flow == "horizontal" else (128.486, 2.886, -39.238)
    assert from_start(states[149.0]) == pytest.approx(last_m, abs=0.05)
    heading_deg = 6.28 if cross_flow == "horizontal" else 5.96
    assert angles_deg(states[149.0])[2] == pytest.approx(heading_deg, abs=0.05)


def test_velocities_of_the_open_loop_turn():
    state = flown(remus(cross_flow="horizontal"), REST, UP_AND_TO_STARBOARD, (10.0, 50.0))
    assert state[10.0][12] == pytest.approx(0.0628, abs=1e-4)
    assert state[50.0][7:10] == pytest.approx((2.5334, -0.1850, 0.0282), abs=2e-4)


def test_a_hull_without_a_computer_stalls_rises_and_glides_on_a_little():
    state = (*remus().initial_state((0.0, 0.0, 30.0), 0.0, 1.5)[:15], 895.5)
    states = flown(remus().adrift(), state, [(0.0, (0.0, 0.0, 0.0))], (10.0, 20.0, 60.0, 100.0, 200.0))
    norths = [states[t_s][0] for t_s in (10.0, 20.0, 60.0, 200.0)]
    assert norths == pytest.approx([6.996, 9.506, 11.862, 12.05], abs=0.02)
    assert [states[t_s][2] for t_s in (10.0, 20.0, 100.0)] == pytest.approx([28.332, 26.189, 8.992], abs=0.02)
    assert states[100.0][9] == pytest.approx(-0.2150, abs=0.001)
    assert all(abs(angles_deg(states[t_s])[1]) < 0.5 for t_s in states)


def test_a_light_hull_floats_at_the_surface():
    model = remus().adrift()
    state = model.step(model.initial_state((0.0, 0.0, 1.0), 0.0), (0.0, 0.0, 0.0), STILL, 0.05, 1200)
    weight_n = mass_kg(model.params) * model.params.gravity_mps2
    under = weight_n / (weight_n + 10.0)
    assert state[2] == pytest.approx((under - 0.5) * 0.19, abs=0.005)
    assert abs(state[9]) < 0.01


def test_steady_speeds_are_proportional_to_the_propeller():
    model = remus()
    speeds = [model.steady_speed_mps(rpm) for rpm in (400.0, 600.0, 800.0, 1000.0, 1200.0, 1525.0)]
    assert speeds == pytest.approx([0.6600, 1.0012, 1.3383, 1.6741, 2.0093, 2.5536], abs=0.001)
    assert model.top_speed_mps == speeds[-1]
    assert [model.steady_rpm(speed) for speed in speeds[:-1]] == pytest.approx([400, 600, 800, 1000, 1200])
    assert model.steady_rpm(0.0) == 0.0


def test_steady_turns_widen_as_the_vehicle_slows():
    model = remus()
    turns = [model.flown_turn(rpm) for rpm in (400.0, 500.0, 600.0, 800.0, 1000.0, 1200.0, 1525.0)]
    assert [turn.radius_m for turn in turns] == pytest.approx(
        [28.6, 25.7, 23.9, 21.6, 20.3, 19.4, 18.5], abs=0.2
    )
    rates_degps = [math.degrees(turn.speed_mps / turn.radius_m) for turn in turns]
    assert rates_degps == pytest.approx([1.30, 1.82, 2.36, 3.49, 4.64, 5.82, 7.77], abs=0.02)
    assert model.turn_radius_m(0.985) == pytest.approx(23.9, abs=0.2)
    assert model.turn_radius_m(1.6448) == pytest.approx(20.3, abs=0.2)
    assert model.turn_radius_m(0.1) == model.turns()[0].radius_m
    assert model.turn_radius_m(9.0) == model.turns()[-1].radius_m


def test_a_gentle_turn_is_wide():
    state = flown(remus(), REST, [(0.0, (FIVE_DEG, 0.0, 800.0))], (60.0,))[60.0]
    assert math.hypot(state[7], state[8]) / state[12] == pytest.approx(49.6, abs=0.2)


def test_lift_in_sway_tightens_the_turn():
    assert remus(lift_in_both_planes=True).flown_turn(800.0).radius_m == pytest.approx(16.1, abs=0.3)


def test_it_cannot_stop():
    handling = remus().handling
    assert handling == (False, 0.8, 1.6, 0.19, 5.0)
    assert remus().resting_command() == (0.0, 0.0, 0.0)


def test_commands_are_limited_and_fins_act_within_their_limits():
    model = remus()
    most_rad = math.radians(15.0)
    assert model.limited_command((1.0, -1.0, 9999.0)) == pytest.approx((most_rad, -most_rad, 1525.0))
    beyond = (*REST[:7], 1.5, *REST[8:13], 2.0, 0.0, 900.0)
    at_limit = (*beyond[:13], most_rad, 0.0, 900.0)
    command = (0.0, 0.0, 900.0)
    assert model.derivative(beyond, command, STILL)[:13] == model.derivative(at_limit, command, STILL)[:13]


def test_a_fin_turns_no_faster_than_its_servo():
    section = preset("remus100")
    servos = replace(section.params.servos, fin_rate_radps=0.1)
    slow = make_model(replace(section, params=replace(section.params, servos=servos)))
    state = slow.step(REST, (0.2, -0.2, 0.0), STILL, 0.01, 100)
    assert state[13:15] == pytest.approx((0.1, -0.1), abs=1e-9)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("diameter_m", 1.6, r"^m\.params\.hull\.diameter_m: 1\.6 is not allowed; allowed: less than"),
        (
            "cross_flow",
            "none",
            r"^m\.params\.hull\.cross_flow: 'none' is not allowed; allowed: both, horizontal",
        ),
        ("cog_z_m", 0.0, r"^m\.params\.hull\.cog_z_m: 0\.0 is not allowed"),
    ],
)
def test_impossible_hulls_are_refused(key, value, words):
    from auv_core.params import dump

    raw = {"kind": "torpedo", "params": dump(preset("remus100").params)}
    raw["params"]["hull"][key] = value
    with pytest.raises(ConfigError, match=words):
        load_section(raw, "m", "auv_core.models")
