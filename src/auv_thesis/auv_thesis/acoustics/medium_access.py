"""
Medium access compared: one modem, 2 to 16 vehicles at rest within half a kilometre, four access schemes.

First modems alone in many fleets, then eight vehicles with agents, as a scenario.

The modem is the preset `evologics_s2c` (32 bytes: 0.362 s on the air); slots of 0.7 s guard 506 m, the
vehicles lie within 433 m of each other. Every vehicle always has a fresh report; the schemes differ in when
they request it. Slotted ALOHA transmits with probability 1/N per slot, ALOHA offers half a packet per airtime
(where its throughput is greatest), carrier sense one.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import yaml
from matplotlib.figure import Figure as Canvas

from auv_core.messages import AcousticEvent, Outcome
from auv_experiment.figures.plotting import marker, vehicle_style
from auv_experiment.recording import acoustic_log
from auv_sim.acoustics.event_log import half_duplex_violations
from auv_sim.acoustics.medium import AcousticMedium
from auv_sim.acoustics.modem import make_modem
from auv_sim.acoustics.talk import talk
from auv_thesis.acoustics.medium import medium_config
from auv_thesis.items import (
    AGREES,
    DIFFERS,
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Claim,
    Figure,
    Row,
    Run,
    RunSpec,
    Table,
    Verdict,
)

PRESET = "evologics_s2c"
SCHEMES = ("tdma", "slotted_aloha", "aloha", "csma")
FLEETS = (2, 4, 8, 16)
SEEDS = (1, 2)
DURATION_S, PERIOD_S, SLOT_S = 300.0, 0.25, 0.7
BOX_M = 250.0
PAYLOAD_BYTES = 32
AIRTIME_S = make_modem(medium_config(PRESET, fleet_size=2).modem).airtime_s(PAYLOAD_BYTES)
_CAUSES = (Outcome.COLLISION, Outcome.HALF_DUPLEX, Outcome.NOISE, Outcome.OUTAGE, Outcome.RANGE)

TEXTBOOK_LOADS = ((4, 0.5), (4, 1.0), (8, 1.0), (8, 2.0))
TEXTBOOK_SLOTS = 12000


@dataclass(frozen=True)
class Cell:
    """
    One scheme and fleet size, over all seeds.

    `throughput_bps` is what an average vehicle receives. `shares` are the shares of all receptions, by
    outcome. A delay lasts from the creation of a report to the end of its reception. The age of information
    is that of the newest report of a neighbour, averaged over time and pairs. `fairness` is Jain's index of
    the sources' throughput, 1 for equal shares.
    """

    scheme: str
    fleet: int
    throughput_bps: float
    shares: dict[Outcome, float]
    delay_s: float
    age_s: float
    fairness: float
    violations: int


@dataclass(frozen=True)
class Log:
    """The acoustic log of a run, and the time at which each packet was made (s), by (source, sequence)."""

    events: Sequence[AcousticEvent]
    made_s: Mapping[tuple[int, int], float]
    fleet: int
    duration_s: float


def scheme_section(scheme: str, fleet: int) -> dict[str, Any]:
    """Return the medium access section of a scheme for a fleet."""
    params: dict[str, float] = {
        "tdma": {"slot_s": SLOT_S},
        "slotted_aloha": {"slot_s": SLOT_S, "transmit_prob": 1.0 / fleet},
        "aloha": {"mean_interval_s": 2.0 * fleet * AIRTIME_S},
        "csma": {"mean_interval_s": fleet * AIRTIME_S},
    }[scheme]
    return {"kind": scheme, "params": params}


def places(fleet: int, seed: int) -> list[tuple[float, float, float]]:
    """Return the positions of the vehicles (m; NED), uniform in the box."""
    drawn = np.random.default_rng(np.random.SeedSequence((seed, fleet))).uniform(0.0, BOX_M, (fleet, 3))
    return [(x, y, z) for x, y, z in drawn.tolist()]


def mean_age_s(log: Log) -> float:
    """
    Return the age of a neighbour's newest report (s), averaged over pairs and over the time since its first
    report.
    """
    heard: defaultdict[tuple[int, int], list[tuple[float, float]]] = defaultdict(list)
    for event in log.events:
        if event.outcome is Outcome.DELIVERED:
            born_s = log.made_s[event.source, event.sequence]
            heard[event.source, event.destination].append((event.end_s, born_s))
    area = time_s = 0.0
    for arrivals in heard.values():
        ordered = [*sorted(arrivals), (log.duration_s, math.inf)]
        newest_s = -math.inf
        for (from_s, born_s), (to_s, _) in pairwise(ordered):
            newest_s = max(newest_s, born_s)
            area += 0.5 * ((from_s - newest_s) + (to_s - newest_s)) * (to_s - from_s)
            time_s += to_s - from_s
    everybody = len(heard) == log.fleet * (log.fleet - 1)
    return area / time_s if time_s > 0.0 and everybody else math.inf


def cell_of(scheme: str, logs: Sequence[Log]) -> Cell:
    """Return the results of a scheme over runs of one fleet size."""
    fleet = logs[0].fleet
    ends = Counter(event.outcome for log in logs for event in log.events)
    total = sum(count for outcome, count in ends.items() if outcome is not Outcome.SENT)
    heard = [[event for event in log.events if event.outcome is Outcome.DELIVERED] for log in logs]
    delays_s = [
        event.end_s - log.made_s[event.source, event.sequence]
        for log, events in zip(logs, heard, strict=True)
        for event in events
    ]
    sources = [Counter(event.source for event in events) for events in heard]
    through = np.array([[count[source] for source in range(1, fleet + 1)] for count in sources], float)
    return Cell(
        scheme,
        fleet,
        8.0 * PAYLOAD_BYTES * ends[Outcome.DELIVERED] / (fleet * sum(log.duration_s for log in logs)),
        {outcome: ends[outcome] / total for outcome in Outcome if outcome is not Outcome.SENT},
        float(np.mean(delays_s)),
        float(np.mean([mean_age_s(log) for log in logs])),
        float(np.mean(through.sum(axis=1) ** 2 / (fleet * np.square(through).sum(axis=1)))),
        sum(len(half_duplex_violations(log.events)) for log in logs),
    )


def measured(scheme: str, fleet: int) -> Cell:
    """Return the results of a scheme with modems at rest."""
    return cell_of(scheme, [_at_rest(scheme, fleet, seed) for seed in SEEDS])


def _at_rest(scheme: str, fleet: int, seed: int) -> Log:
    config = medium_config(
        PRESET, fleet_size=fleet, seed=seed, period_s=PERIOD_S, mac=scheme_section(scheme, fleet)
    )
    where = places(fleet, seed)
    made: dict[tuple[int, int], int] = {}
    ticks = range(round(DURATION_S / PERIOD_S))
    events = talk(AcousticMedium(config), ticks, lambda _tick: where, payload_bytes=PAYLOAD_BYTES, made=made)
    return Log(events, {key: tick * PERIOD_S for key, tick in made.items()}, fleet, DURATION_S)


def flown(scheme: str, run: Run) -> Cell:
    """Return the results of a scheme in a run of a scenario."""
    scenario, recording = run.scenario, run.recording
    made_s = {
        (source, sequence): tick * scenario.period_s for tick, source, sequence in recording.sent.tolist()
    }
    log = Log(acoustic_log(recording), made_s, len(scenario.vehicles), scenario.duration_s)
    return cell_of(scheme, [log])


@cache
def cells() -> tuple[Cell, ...]:
    """Return the results of every scheme at every fleet size."""
    return tuple(measured(scheme, fleet) for scheme in SCHEMES for fleet in FLEETS)


@cache
def textbook(sources: int, load: float) -> tuple[float, float]:
    """Return the throughput of slotted ALOHA per slot at one listener: measured, and G (1 - G/N)^(N - 1)."""
    mac = {"kind": "slotted_aloha", "params": {"slot_s": 0.25, "transmit_prob": load / sources}}
    modem = {"kind": "fixed_rate", "params": {"bit_rate_bps": 2000.0}}
    config = medium_config("lossy", fleet_size=sources + 1, seed=7, period_s=0.25, mac=mac, modem=modem,
                           outage={"kind": "none"})  # fmt: skip
    medium = AcousticMedium(config)
    where = [(10.0 * i, 0.0, 10.0) for i in range(sources + 1)]
    talk(medium, range(TEXTBOOK_SLOTS), lambda _tick: where, talkers=range(1, sources + 1))
    heard = sum(medium.links[source, sources + 1].delivered for source in range(1, sources + 1))
    return heard / TEXTBOOK_SLOTS, load * (1.0 - load / sources) ** (sources - 1)


def _draw(canvas: Canvas, runs: list[Run]) -> None:
    del runs
    panels: tuple[tuple[str, Any], ...] = (
        ("received by a vehicle (bit/s)", lambda cell: cell.throughput_bps),
        ("delivery ratio", lambda cell: cell.shares[Outcome.DELIVERED]),
        ("mean delay (s)", lambda cell: cell.delay_s),
        ("mean age of information (s)", lambda cell: cell.age_s),
    )
    grid = canvas.subplots(2, 2, sharex=True).flat
    for axes, (label, value) in zip(grid, panels, strict=True):
        for index, scheme in enumerate(SCHEMES):
            own = [cell for cell in cells() if cell.scheme == scheme]
            axes.plot(
                [cell.fleet for cell in own],
                [value(cell) for cell in own],
                label=scheme,
                marker=marker(index),
                **vehicle_style(index),
            )
        axes.set_xscale("log", base=2)
        axes.set_xticks(FLEETS, [str(fleet) for fleet in FLEETS])
        axes.set_ylim(bottom=0.0)
        axes.set_ylabel(label)
    for axes in canvas.axes[2:]:
        axes.set_xlabel("vehicles")
    canvas.axes[3].legend(loc="upper left")


def _rows(runs: list[Run]) -> list[Row]:
    del runs
    return [_row(cell) for cell in cells()]


def _flown_rows(runs: list[Run]) -> list[Row]:
    return [_row(flown(scheme, run)) for scheme, run in zip(SCHEMES, runs, strict=True)]


def _row(cell: Cell) -> Row:
    losses = ", ".join(
        f"{outcome.name.lower().replace('_', '-')} {100.0 * cell.shares[outcome]:.1f} %"
        for outcome in _CAUSES
        if cell.shares[outcome] > 0.0
    )
    delivered = 100.0 * cell.shares[Outcome.DELIVERED]
    ours = (
        f"{cell.throughput_bps:.0f} bit/s heard, {delivered:.1f} % delivered, delay "
        f"{cell.delay_s:.2f} s, age {cell.age_s:.2f} s, fairness {cell.fairness:.3f}"
    )
    return Row(f"{cell.scheme}, {cell.fleet} vehicles", "not given", ours, NO_NUMBER, losses or "no losses")


def _textbook_rows(runs: list[Run]) -> list[Row]:
    del runs
    rows = []
    for sources, load in TEXTBOOK_LOADS:
        found, expected = textbook(sources, load)
        rows.append(
            Row(
                f"slotted ALOHA, {sources} sources, G = {load:g}: packets heard per slot",
                f"{expected:.4f} (formula)",
                f"{found:.4f} ({100.0 * (found / expected - 1.0):+.1f} %)",
                AGREES if abs(found / expected - 1.0) <= 0.03 else DIFFERS,
                f"{TEXTBOOK_SLOTS} slots, no capture",
            )
        )
    return rows


def _judge_tdma(runs: list[Run]) -> Verdict:
    del runs
    own = [cell for cell in cells() if cell.scheme == "tdma"]
    lost = sum(cell.shares[Outcome.COLLISION] + cell.shares[Outcome.HALF_DUPLEX] for cell in own)
    others = [cell for cell in cells() if cell.scheme != "tdma" and cell.fleet == max(FLEETS)]
    words = ", ".join(
        f"{cell.scheme} {100.0 * (1.0 - cell.shares[Outcome.DELIVERED]):.0f} %" for cell in others
    )
    evidence = (
        f"share lost to collisions and half-duplex, {len(own)} fleets: {lost:g}; of {max(FLEETS)} vehicles "
        f"the others lose {words}"
    )
    return Verdict(HOLDS if lost == 0.0 else DOES_NOT_HOLD, evidence)


def _judge_textbook(runs: list[Run]) -> Verdict:
    del runs
    errors = [found / expected - 1.0 for found, expected in (textbook(*load) for load in TEXTBOOK_LOADS)]
    worst = max(errors, key=abs)
    evidence = (
        f"{len(errors)} loads of {TEXTBOOK_SLOTS} slots: within {100.0 * abs(worst):.1f} % of the formula"
    )
    return Verdict(HOLDS if abs(worst) <= 0.03 else DOES_NOT_HOLD, evidence)


def _judge_half_duplex(runs: list[Run]) -> Verdict:
    del runs
    found = sum(cell.violations for cell in cells())
    evidence = f"{len(cells()) * len(SEEDS)} logs of {DURATION_S:g} s: {found} receptions while transmitting"
    return Verdict(HOLDS if found == 0 else DOES_NOT_HOLD, evidence)


def _judge_age(runs: list[Run]) -> Verdict:
    del runs
    ages = {(cell.scheme, cell.fleet): cell.age_s for cell in cells()}
    words, wins = [], 0
    for fleet in FLEETS:
        best_s, best = min((ages[scheme, fleet], scheme) for scheme in SCHEMES if scheme != "tdma")
        wins += ages["tdma", fleet] < best_s
        words.append(f"{fleet} vehicles: {ages['tdma', fleet]:.2f} s, next {best} {best_s:.2f} s")
    verdict = HOLDS if wins == len(FLEETS) else HOLDS_IN_PART if wins else DOES_NOT_HOLD
    return Verdict(verdict, f"mean age of information with tdma; {'; '.join(words)}")


FIGURES = (
    Figure(
        "A.12",
        "Medium access compared at 2 to 16 vehicles",
        (),
        _draw,
        "One modem (evologics_s2c), vehicles at rest within 433 m of each other, two seeds of 300 s. Delay "
        "and age count from the moment at which a report is made.",
    ),
)

FLOWN = tuple(
    RunSpec(
        "medium_access",
        (f"acoustics.mac={yaml.safe_dump(scheme_section(scheme, 8), default_flow_style=True).strip()}",),
    )
    for scheme in SCHEMES
)

TABLES = (
    Table("A.12", "Medium access compared: throughput, losses by cause, delay, age, fairness", (), _rows),
    Table("A.15", "Medium access flown as a scenario: eight vehicles that keep station", FLOWN, _flown_rows),
    Table("A.13", "Slotted ALOHA compared with the textbook", (), _textbook_rows, "formula"),
)

CLAIMS = (
    Claim("A.13", "TDMA never collides while its guard covers the longest travel time.", (), _judge_tdma),
    Claim("A.14", "Slotted ALOHA carries G (1 - G/N)^(N - 1) packets per slot.", (), _judge_textbook),
    Claim("A.15", "No modem hears while it transmits.", (), _judge_half_duplex),
    Claim("A.16", "TDMA keeps reports freshest of the four schemes.", (), _judge_age),
)
