"""Whether the modems of a flock hear each other at the starts."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

from auv_core.geometry import Vec3, distance
from auv_experiment.scenario.teams import flocks, starts_of
from auv_flocking.agent_config import report_format
from auv_sim.acoustics.modem import AcousticModem, LevelModem, make_modem
from auv_sim.acoustics.propagation import SoundPropagation, make_propagation

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

# A link that carries fewer reports than one in a hundred, with ambient noise alone, is none.
_LEAST_LOG_SUCCESS = math.log(0.01)


def check_hearing(scenario: Scenario) -> None:
    """Check that the modems of a flock form one connected network at the starts."""
    for indices in flocks(scenario):
        starts = dict(starts_of(scenario, indices))
        if len(starts) == len(indices):
            _check_connected(scenario, starts)


def _check_connected(scenario: Scenario, starts: dict[int, Vec3]) -> None:
    modem, propagation = (
        make_modem(scenario.acoustics.modem),
        make_propagation(scenario.acoustics.propagation),
    )
    first = min(starts)
    form = report_format(scenario.agents[first], len(scenario.vehicles))
    hears = partial(_hears, modem, propagation, form.payload_bytes)
    deaf = set(starts) - {first}
    heard = [first]
    while heard and deaf:
        speaker = starts[heard.pop()]
        reached = {index for index in deaf if hears(speaker, starts[index])}
        deaf -= reached
        heard += sorted(reached)
    if deaf:
        raise ValueError(
            f"vehicles[{min(deaf)}].position_ned_m: out of range of vehicles[{first}] and of every vehicle "
            "connected to it, which is not allowed; allowed: a start within range of acoustics.modem "
            f"({scenario.acoustics.modem.kind})"
        )


def _hears(
    modem: AcousticModem, propagation: SoundPropagation, payload_bytes: int, source: Vec3, receiver: Vec3
) -> bool:
    """Return whether a modem recognises packets and gets some of them right, in ambient noise alone."""
    if distance(source, receiver) > modem.max_range_m:
        return False
    if not isinstance(modem, LevelModem):
        return True
    loss_db = propagation.loss_db(source, receiver, modem.frequency_khz)
    snr_ratio = modem.snr_ratio(loss_db)
    return modem.acquires(snr_ratio) and modem.log_success(snr_ratio, payload_bytes) > _LEAST_LOG_SUCCESS
