"""Torpedoes for tests: presets with changes, and flights with a command from a time on."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import yaml

import auv_core.models
from auv_core.models import make_model
from auv_core.params import load_section

PRESETS = Path(auv_core.models.__file__).parent / "presets"
STILL = (0.0, 0.0, 0.0)


@cache
def preset(name):
    """Return the section of a preset."""
    raw = yaml.safe_load((PRESETS / f"{name}.yaml").read_text(encoding="utf-8"))
    return load_section(raw, name, "auv_core.models")


@cache
def remus(**hull) -> Any:
    """Return the model `remus100` with changes of its hull."""
    section = preset("remus100")
    changed = replace(section.params.hull, **hull)
    return make_model(replace(section, params=replace(section.params, hull=changed)))


@cache
def lauv() -> Any:
    """Return the model `lauv`."""
    return make_model(preset("lauv"))


def angles_deg(state):
    """Return roll, pitch and heading (deg)."""
    qw, qx, qy, qz = state[3:7]
    roll = math.atan2(2.0 * (qw * qx + qy * qz), 1.0 - 2.0 * (qx * qx + qy * qy))
    pitch = math.asin(2.0 * (qw * qy - qz * qx))
    heading = math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
    return tuple(map(math.degrees, (roll, pitch, heading)))


def flown(model, state, commands, times_s, *, dt_s=0.05):
    """
    Return the states at some times (s), for `commands` as pairs of the time from which one holds (s) and
    rudder, stern plane (rad) and propeller (rpm).
    """
    stops = sorted({*times_s, *(start_s for start_s, _ in commands if start_s > 0.0)})
    states, t_s = {}, 0.0
    for stop_s in stops:
        command = max((each for each in commands if each[0] <= t_s), key=lambda each: each[0])[1]
        steps = round((stop_s - t_s) / dt_s)
        state = model.step(state, model.limited_command(command), STILL, dt_s, steps)
        t_s = stop_s
        states[stop_s] = state
    return {t_s: states[t_s] for t_s in times_s}
