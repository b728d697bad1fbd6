"""Claims about propagation by tables of the Bellhop solver: with a sea in its place, and with it."""

import importlib.util
import json
import math
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from auv_core.params import ConfigError, load
from auv_sim.acoustics.propagation import bellhop
from auv_sim.acoustics.propagation.bellhop import INAUDIBLE_DB, Params, Propagation
from auv_sim.acoustics.water import absorption_db_per_km, transmission_loss_db

KHZ = 25.0
SPEED_MPS = 1480.0
LATER_S = 0.01
SMALL = Params(
    water_depth_m=60.0, sound_speed_mps=(SPEED_MPS,), max_range_m=400.0, range_step_m=20.0, depth_step_m=10.0
)
with_the_solver = pytest.mark.skipif(
    not bellhop.is_installed(), reason="needs ./scripts/setup --with bellhop"
)


class Sea:
    """A solver that knows one sea: a straight ray, listed after a later one of its own strength."""

    def __init__(self, later_amplitude=0.25, deaf_below_m=math.inf):
        self.asked = []
        self._later = later_amplitude
        self._deaf_below_m = deaf_below_m

    def __call__(self, case):
        case = json.loads(case)
        (source_m,) = case["source"]["depth"]
        self.asked.append(source_m)
        places = [(r, z) for r in case["receivers"]["range"] for z in case["receivers"]["depth"]]
        slants_m = np.array([math.hypot(r, z - source_m) for r, z in places if z < self._deaf_below_m])
        counts = [2 * (z < self._deaf_below_m) for _, z in places]
        return {
            "arrival_offset": np.cumsum([0, *counts]),
            "amplitude": np.stack([self._later / slants_m, 1.0 / slants_m], axis=1).ravel(),
            "phase_rad": np.tile([math.pi, 0.0], len(slants_m)),
            "time_s": np.stack([slants_m / SPEED_MPS + LATER_S, slants_m / SPEED_MPS], axis=1).ravel(),
        }


def _pairs():
    rng = np.random.default_rng(3)
    for _ in range(30):
        range_m, angle = rng.uniform(0.1, 399.0), rng.uniform(-3.0, 3.0)
        source = (5.0, -7.0, float(rng.uniform(5.0, 55.0)))
        east_m, depth_m = -7.0 + range_m * math.sin(angle), rng.uniform(0.0, 60.0)
        yield source, (5.0 + range_m * math.cos(angle), float(east_m), float(depth_m))


def test_between_places_of_the_table_straight_rays_keep_their_delay_and_loss():
    propagation = Propagation(SMALL, Sea(later_amplitude=0.0))
    for source, receiver in _pairs():
        slant_m = math.dist(source, receiver)
        assert propagation.delay_s(source, receiver) == pytest.approx(slant_m / SPEED_MPS, rel=1e-12)
        expected_db = transmission_loss_db(slant_m, KHZ, 2.0)
        assert propagation.loss_db(source, receiver, KHZ) == pytest.approx(expected_db, abs=1e-9)


def test_powers_of_arrivals_add_up_and_the_first_one_gives_the_time():
    source, receiver = (0.0, 0.0, 25.0), (200.0, 0.0, 25.0)
    propagation = Propagation(SMALL, Sea(later_amplitude=0.5))
    assert propagation.delay_s(source, receiver) == pytest.approx(200.0 / SPEED_MPS)
    later_db = 0.001 * absorption_db_per_km(0.5) * SPEED_MPS * LATER_S
    sum_db = 10.0 * math.log10(1.0 + 0.25 * 10.0 ** (-0.1 * later_db))
    expected_db = transmission_loss_db(200.0, 0.5, 2.0) - sum_db
    assert propagation.loss_db(source, receiver, 0.5) == pytest.approx(expected_db, abs=1e-6)


def test_pressures_of_arrivals_interfere_at_the_frequency_of_the_modem():
    params = Params(**{**vars(SMALL), "sum": "coherent"})
    source, receiver = (0.0, 0.0, 25.0), (200.0, 0.0, 25.0)
    propagation = Propagation(params, Sea(later_amplitude=1.0))
    # 0.01 s is one period of 100 Hz, and the later ray is turned over; half a period turns it back.
    in_phase_db, against_db = (propagation.loss_db(source, receiver, khz) for khz in (0.05, 0.1))
    assert in_phase_db == pytest.approx(
        transmission_loss_db(200.0, 0.05, 2.0) - 20.0 * math.log10(2.0), abs=1e-3
    )
    assert against_db > in_phase_db + 60.0


def test_the_strongest_arrival_gives_the_time_where_that_is_asked_for():
    params = Params(**{**vars(SMALL), "arrival": "strongest"})
    source, receiver = (0.0, 0.0, 25.0), (200.0, 0.0, 25.0)
    for amplitude, later_s in ((0.5, 0.0), (2.0, LATER_S)):
        delay_s = Propagation(params, Sea(later_amplitude=amplitude)).delay_s(source, receiver)
        assert delay_s == pytest.approx(200.0 / SPEED_MPS + later_s)


def test_nothing_is_heard_where_no_ray_comes_nor_beyond_the_table():
    propagation = Propagation(SMALL, Sea(deaf_below_m=30.0))
    source = (0.0, 0.0, 15.0)
    for receiver in ((200.0, 0.0, 45.0), (400.1, 0.0, 15.0), (1e6, 0.0, 15.0)):
        assert propagation.loss_db(source, receiver, KHZ) == INAUDIBLE_DB
        straight_s = math.dist(source, receiver) / SPEED_MPS
        assert propagation.delay_s(source, receiver) == pytest.approx(straight_s)
    assert propagation.loss_db(source, (200.0, 0.0, 15.0), KHZ) < 60.0


def test_each_source_depth_is_solved_once_and_only_when_it_is_used():
    sea = Sea()
    pairs = [((0.0, 0.0, depth_m), (100.0, 0.0, 30.0)) for depth_m in (25.0, 28.0, 26.0)]
    propagations = [Propagation(SMALL, sea) for _ in range(2)]
    assert sea.asked == []
    propagations[0].delay_s(*pairs[0])
    assert sea.asked == [25.0]
    for propagation in propagations:
        for pair in pairs:
            propagation.delay_s(*pair)
            propagation.loss_db(*pair, KHZ)
    assert sea.asked == [25.0, 35.0]


@pytest.mark.parametrize(
    ("raw", "message"),
    [
        ({"sound_speed_mps": [1500.0, 1490.0]}, "p.sound_speed_depths_m: 1 depths are not allowed"),
        (
            {"sound_speed_mps": [1500.0, 1490.0], "sound_speed_depths_m": [0.0, 0.0]},
            "p.sound_speed_depths_m: [0.0, 0.0] is not allowed",
        ),
        ({"max_range_m": 30.0}, "p.range_step_m: 20.0 is not allowed"),
        ({"max_range_m": 100000.0}, "p.range_step_m: a table of 100000 places is not allowed"),
    ],
)
def test_a_table_that_cannot_be_made_is_refused(raw, message):
    with pytest.raises(ConfigError) as refused:
        load(Params, raw, "p")
    assert str(refused.value).startswith(message)
    assert "allowed: " in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("raise SystemExit('the sea is dry')", "the Bellhop solver failed with status 1: the sea is dry"),
        ("input()\nwhile True: pass", "the Bellhop solver did not end within 0.5 s"),
    ],
)
def test_a_solver_that_fails_is_one_line(tmp_path, monkeypatch, program, message):
    (tmp_path / "solver.py").write_text(program, encoding="utf-8")
    monkeypatch.setattr(bellhop, "_SOLVER", tmp_path / "solver.py")
    monkeypatch.setattr(bellhop, "_TIMEOUT_S", 0.5 if "input" in program else 60.0)
    with pytest.raises(RuntimeError) as failed:
        bellhop.run_solver("{}")
    assert str(failed.value) == message


@pytest.mark.slow
@with_the_solver
def test_in_deep_water_of_one_speed_sound_goes_straight_and_spreads_as_a_sphere():
    propagation = Propagation(Params(water_depth_m=3000.0, depth_step_m=100.0, max_range_m=1000.0))
    rng = np.random.default_rng(1)
    for _ in range(200):
        source, receiver = (0.0, 0.0, 1500.0), (rng.uniform(1.0, 999.0), 0.0, rng.uniform(1400.0, 1600.0))
        slant_m = math.dist(source, receiver)
        assert propagation.delay_s(source, receiver) == pytest.approx(slant_m / 1500.0, rel=1e-6)
        loss_db = propagation.loss_db(source, receiver, KHZ)
        assert loss_db == pytest.approx(transmission_loss_db(slant_m, KHZ, 2.0), abs=0.05)


@pytest.mark.slow
@with_the_solver
@pytest.mark.parametrize("khz", [0.5, 2.0])
def test_over_a_bottom_that_swallows_all_the_surface_makes_lloyds_mirror(khz):
    params = Params(
        water_depth_m=1000.0, depth_step_m=10.0, max_range_m=1500.0, range_step_m=5.0, beams=5000,
        sum="coherent",
        bottom_sound_speed_mps=1500.0, bottom_density_kgpm3=1000.0, bottom_absorption_db=0.0,
    )  # fmt: skip
    propagation = Propagation(params)
    source_m, receiver_m, wave_number = 25.0, 45.0, 2000.0 * math.pi * khz / 1500.0
    off_db = []
    for range_m in params.ranges_m()[3::7]:
        direct_m, image_m = (math.hypot(range_m, receiver_m - s) for s in (source_m, -source_m))
        pressure = (
            np.exp(1j * wave_number * direct_m) / direct_m - np.exp(1j * wave_number * image_m) / image_m
        )
        mirror_db = absorption_db_per_km(khz) * direct_m / 1000.0 - 20.0 * math.log10(abs(pressure))
        places = (0.0, 0.0, source_m), (float(range_m), 0.0, receiver_m)
        off_db.append(abs(propagation.loss_db(*places, khz) - mirror_db))
    assert np.median(off_db) < 0.01
    assert max(off_db) < 1.0, "in the minima, too"


@pytest.mark.slow
@with_the_solver
def test_sound_that_is_bent_away_leaves_a_shadow():
    falling: dict[str, Any] = {"sound_speed_mps": (1520.0, 1480.0), "sound_speed_depths_m": (0.0, 100.0)}
    swallowing: dict[str, Any] = {
        "bottom_sound_speed_mps": 1480.0,
        "bottom_density_kgpm3": 1000.0,
        "bottom_absorption_db": 0.0,
    }
    bent = Propagation(Params(**falling, **swallowing))
    straight = Propagation(Params(**{**swallowing, "bottom_sound_speed_mps": 1500.0}))
    source, receiver = (0.0, 0.0, 12.5), (1500.0, 0.0, 12.5)
    assert bent.loss_db(source, receiver, KHZ) > straight.loss_db(source, receiver, KHZ) + 20.0


@pytest.mark.slow
@with_the_solver
def test_another_process_gets_the_same_numbers_to_the_last_bit():
    program = """
from auv_sim.acoustics.propagation.bellhop import Params, Propagation
p = Propagation(Params(sound_speed_mps=(1510.0, 1490.0), sound_speed_depths_m=(0.0, 80.0)))
for depth_m in (3.0, 20.0, 77.7):
    places = (0.0, 0.0, depth_m), (777.7, 3.0, 33.3)
    print(p.delay_s(*places).hex(), p.loss_db(*places, 25.0).hex())
"""
    folders = [path for path in sys.path if path]
    program = f"import sys; sys.path[:0] = {folders!r}" + program
    first, second = (
        subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=True
        )
        for _ in range(2)
    )
    assert first.stdout.count("\n") == 3
    assert first.stdout == second.stdout


def test_without_the_solver_the_line_names_the_command_that_brings_it(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _name: None)
    with pytest.raises(
        ValueError, match=r"^propagation\.kind: 'bellhop' is not allowed, since .*--with bellhop$"
    ):
        Propagation(Params())
