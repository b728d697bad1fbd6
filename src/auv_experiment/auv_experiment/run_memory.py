"""Memory of a run: a run that does not fit into the free memory is refused before it starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from auv_core.machine.free_memory import free_bytes, gigabytes
from auv_core.models import make_model
from auv_core.params import ConfigError
from auv_experiment.recording_shapes import bytes_of_rows, bytes_per_tick
from auv_flocking.neighbours.track import HISTORY_S, MOST_MEASUREMENTS
from auv_sim.acoustics.mac import make_mac

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_PROGRAM_BYTES = 230e6
_COPIES = 1.5
"""Metrics and figures take half of the recording in addition. Measured, like the following numbers."""
_BYTES_PER_PAIR = 96
"""Bytes that metrics compute for each pair of vehicles and tick."""
_BYTES_PER_MEASUREMENT = 3500
"""Bytes of a neighbour filter's history."""
_MAC_TICKS = 100


def check_memory(scenario: Scenario, *, has_nodes: bool = False) -> None:
    """
    Refuse a run that does not fit into the free memory.

    Parameters
    ----------
    scenario : Scenario
        The scenario to fly.
    has_nodes : bool
        Whether nodes fly it and write a bag: then only their neighbour filters count.

    Raises
    ------
    ConfigError
        With one line for the user.

    """
    fixed = _PROGRAM_BYTES + _filter_bytes(scenario)
    growing = 0.0 if has_nodes else _report_bytes(scenario)
    free = free_bytes()
    if fixed + growing <= free:
        return
    where = "vehicles" if fixed > free else "duration_s"
    longest_s = scenario.duration_s * (free - fixed) / growing if growing else 0.0
    allowed = "fewer vehicles" if fixed > free else f"at most about {longest_s:.2g} s here, or fewer vehicles"
    raise ConfigError(
        f"scenario.{where}: {scenario.duration_s:g} s of {len(scenario.vehicles)} vehicles take about "
        f"{gigabytes(fixed + growing)} of memory, and {gigabytes(free)} are free; allowed: {allowed}"
    )


def memory_warning(scenario: Scenario) -> str:
    """
    Return one line if a flight of nodes fits into memory but its report will not, otherwise an empty text.
    """
    needed, free = _PROGRAM_BYTES + _report_bytes(scenario), free_bytes()
    if needed <= free:
        return ""
    return (
        f"metrics and figures of this run take about {gigabytes(needed)} of memory, and {gigabytes(free)} "
        "are free: the bag is written all the same, and --report makes them on a larger machine"
    )


def run_bytes(scenario: Scenario) -> float:
    """Return an estimate of the peak memory of a run in one process (bytes)."""
    return _PROGRAM_BYTES + _filter_bytes(scenario) + _report_bytes(scenario)


def _report_bytes(scenario: Scenario) -> float:
    """Return the size of a recording plus the memory for metrics and figures (bytes)."""
    count = len(scenario.vehicles)
    is_sampled = scenario.sampling == "sampled"
    actuators = max(len(make_model(vehicle.model).actuators) for vehicle in scenario.vehicles)
    kept = float(bytes_per_tick(count, has_neighbours=is_sampled, n_actuators=actuators))
    if is_sampled:
        packets = _packets_per_tick(scenario)
        kept += bytes_of_rows(sent=packets, heard=packets * (count - 1))
    return scenario.ticks * (_COPIES * kept + _BYTES_PER_PAIR * count * (count - 1) / 2)


def _filter_bytes(scenario: Scenario) -> float:
    """Return the memory of all vehicles' neighbour filters (bytes)."""
    count = len(scenario.vehicles)
    if scenario.sampling != "sampled" or count < 2:
        return 0.0
    heard_per_tick = _packets_per_tick(scenario) / count
    remembered = min(
        MOST_MEASUREMENTS, scenario.ticks * heard_per_tick, HISTORY_S / scenario.period_s * heard_per_tick
    )
    return _BYTES_PER_MEASUREMENT * count * (count - 1) * remembered


def _packets_per_tick(scenario: Scenario) -> float:
    """Return how many packets the fleet sends per tick under its medium access."""
    section, count = scenario.acoustics.mac, len(scenario.vehicles)
    mac = make_mac(section, count, scenario.seed)
    ticks = min(_MAC_TICKS, scenario.ticks)
    starts = [
        mac.opportunity_s(address, tick, scenario.period_s)
        for tick in range(ticks)
        for address in range(1, count + 1)
    ]
    return sum(start_s is not None for start_s in starts) / ticks
