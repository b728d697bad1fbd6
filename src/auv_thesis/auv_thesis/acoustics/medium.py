"""
Range of each preset modem: measured deliveries compared with the packet error probability.

Two modems are at rest and one transmits. Packets never overlap, so that losses are due to range, noise or
outage. The analytic value is computed here from the formulas and the preset's numbers, not by the medium's
own code.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from matplotlib.figure import Figure as Canvas
from scipy.stats import binom, binomtest

import auv_sim.acoustics
from auv_core.messages import Outcome
from auv_core.params import load
from auv_experiment.confidence import CONFIDENCE
from auv_experiment.confidence.binomial import wilson_interval
from auv_experiment.figures.plotting import colour, marker
from auv_sim.acoustics import codes, water
from auv_sim.acoustics.event_log import half_duplex_violations
from auv_sim.acoustics.medium import AcousticMedium, MediumConfig
from auv_sim.acoustics.talk import talk
from auv_thesis.items import (
    AGREES,
    DIFFERS,
    DOES_NOT_HOLD,
    HOLDS,
    Claim,
    Figure,
    Row,
    Run,
    RunSpec,
    Table,
    Verdict,
)

PRESETS = ("ideal", "lossy", "fast", "micromodem_fsk", "micromodem_psk", "micromodem_fdp", "evologics_s2c")
RANGES_M = (50.0, 100.0, *(250.0 * i for i in range(1, 33)))
TABLE_RANGES_M = (50.0, 1000.0, 2000.0, 3000.0, 3500.0, 4000.0, 5000.0, 6000.0, 7000.0)
PACKETS = 500
PAYLOAD_BYTES = 32
FIRST_SEED = 1000


@dataclass(frozen=True)
class Cell:
    """
    One preset at one range: how many of the completed packets were delivered, and the analytic delivery
    ratio.
    """

    preset: str
    range_m: float
    sent: int
    delivered: int
    expected: float
    violations: int

    @property
    def band(self) -> tuple[float, float]:
        """Wilson's interval of the delivery ratio."""
        low, high = wilson_interval(self.delivered, self.sent)
        return float(low), float(high)

    @property
    def is_inside(self) -> bool:
        """Whether the analytic value lies within the interval, with a tolerance for rounding at its ends."""
        low, high = self.band
        return low - 1e-9 <= self.expected <= high + 1e-9


def preset_sections(name: str) -> dict[str, Any]:
    """Return the sections of an acoustic preset, as in its file."""
    path = Path(str(auv_sim.acoustics.__file__)).parent / "presets" / f"{name}.yaml"
    sections: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return sections


def medium_config(preset: str, **changes: Any) -> MediumConfig:
    """Return the configuration of a medium from a preset and changes."""
    return load(MediumConfig, {**preset_sections(preset), **changes}, "acoustics")


def expected_delivery(config: MediumConfig, range_m: float) -> float:
    """Return the probability that a packet is delivered over a range if no other packet interferes."""
    modem, outage = config.modem.params, config.outage.params
    luck = 1.0 - getattr(outage, "loss_prob", 0.0)
    if config.modem.kind != "noise_limited":
        return luck if range_m <= getattr(modem, "max_range_m", math.inf) else 0.0
    level_db = modem.source_level_db
    if level_db is None:
        level_db = water.source_level_db(modem.power_w, modem.directivity_db)
    khz = modem.carrier_hz / 1000.0
    loss_db = water.transmission_loss_db(range_m, khz, config.propagation.params.spreading_exponent)
    noise_db = water.ambient_noise_db(khz, modem.shipping_ratio, modem.wind_mps)
    snr_db = level_db - loss_db - noise_db - 10.0 * math.log10(modem.bandwidth_hz)
    if snr_db < modem.acquisition_db:
        return 0.0
    frames = math.ceil(PAYLOAD_BYTES / modem.frame_bytes)
    if modem.frame_error_snr_db:
        error_prob = np.interp(snr_db, modem.frame_error_snr_db, modem.frame_error_probs)
        return luck * float(1.0 - error_prob) ** frames
    return luck * (1.0 - _closed_form(modem, snr_db)) ** (8 * modem.frame_bytes * frames)


def _closed_form(modem: Any, snr_db: float) -> float:
    """Return the error probability of a bit of data from Eb/N0 = SNR x B / R, modulation and code."""
    bit_errors = {"bpsk": water.bpsk_bit_error_prob, "fsk": water.fsk_bit_error_prob}[modem.modulation]
    ebn0 = 10.0 ** (0.1 * snr_db) * modem.bandwidth_hz / modem.bit_rate_bps
    if modem.code == "none":
        return bit_errors(ebn0)
    on_air = max(bit_errors(0.5 * ebn0), 1e-9)  # SciPy's density overflows far below
    distances, paths = (np.array(column) for column in zip(*codes.PATHS_K9.items(), strict=True))
    more_than_half = binom.sf(distances // 2, distances, on_air)
    tie = binom.pmf(distances // 2, distances, on_air)
    return min(float(paths @ (more_than_half + 0.5 * tie)), 0.5)


def measured(preset: str, range_m: float, seed: int) -> Cell:
    """Count the packets delivered from one modem to another over a range."""
    # One packet per tick; a tick is as long as a packet takes over the longest range.
    turn_s = 10.0
    mac = {"kind": "tdma", "params": {"slot_s": turn_s}}
    config = medium_config(preset, fleet_size=2, seed=seed, period_s=turn_s, mac=mac)
    places = ((0.0, 0.0, 20.0), (range_m, 0.0, 20.0))
    medium = AcousticMedium(config)
    events = talk(
        medium, range(2 * PACKETS + 2), lambda _tick: places, payload_bytes=PAYLOAD_BYTES, talkers={1}
    )
    link = medium.links[1, 2]
    expected = expected_delivery(config, range_m)
    # The last packet is still on its way.
    ended = link.delivered + link.lost
    return Cell(preset, range_m, ended, link.delivered, expected, len(half_duplex_violations(events)))


@cache
def sweep() -> tuple[Cell, ...]:
    """Return every preset at every range, each with its own random numbers."""
    cells = [(preset, range_m) for preset in PRESETS for range_m in RANGES_M]
    return tuple(measured(*cell, FIRST_SEED + index) for index, cell in enumerate(cells))


def _draw(canvas: Canvas, runs: list[Run]) -> None:
    del runs
    grid = canvas.subplots(2, 4, sharex=True, sharey=True).flat
    grid[len(PRESETS)].set_visible(False)
    for index, (axes, preset) in enumerate(zip(grid, PRESETS, strict=False)):
        cells = [cell for cell in sweep() if cell.preset == preset]
        config = medium_config(preset, fleet_size=2)
        fine_m = np.linspace(RANGES_M[0], RANGES_M[-1], 801).tolist()
        axes.plot(
            [0.001 * x for x in fine_m],
            [expected_delivery(config, x) for x in fine_m],
            color="0.55",
            label="analytic",
        )
        ratios = [cell.delivered / cell.sent for cell in cells]
        bars = [
            [max(r - cell.band[0], 0.0) for r, cell in zip(ratios, cells, strict=True)],
            [max(cell.band[1] - r, 0.0) for r, cell in zip(ratios, cells, strict=True)],
        ]
        axes.errorbar(
            [0.001 * cell.range_m for cell in cells], ratios, yerr=bars, linestyle="none", markersize=3.0,
            color=colour(index), marker=marker(index), elinewidth=0.8, label="measured, 95 %",
        )  # fmt: skip
        axes.set_title(preset)
        axes.set_ylim(-0.05, 1.05)
        if index % 4 == 0:
            axes.set_ylabel("delivery ratio")
        if index >= len(PRESETS) - 4:
            axes.set_xlabel("range (km)")
            axes.tick_params(labelbottom=True)
        if index == 0:
            axes.legend(loc="lower left")


def _rows(runs: list[Run]) -> list[Row]:
    del runs
    rows = []
    for cell in sweep():
        if cell.range_m not in TABLE_RANGES_M:
            continue
        low, high = cell.band
        rows.append(
            Row(
                f"{cell.preset}, {cell.range_m:g} m: delivery ratio",
                f"{cell.expected:.4f} (analytic)",
                f"{cell.delivered / cell.sent:.4f}, 95 % interval [{low:.4f}, {high:.4f}]",
                AGREES if cell.is_inside else DIFFERS,
                f"{cell.delivered} of {cell.sent} packets of {PAYLOAD_BYTES} bytes",
            )
        )
    return rows


def _flown_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for run in runs:
        config = run.scenario.medium_config
        ends = [event for event in run.recording.events.tolist() if event[1] != Outcome.SENT]
        for other in range(2, config.fleet_size + 1):
            range_m = math.dist(*run.recording.position_ned_m[-1, [0, other - 1]].tolist())
            pairs = ((1, other), (other, 1))
            own = [Outcome(event[1]) for event in ends if (event[2], event[3]) in pairs]
            delivered = own.count(Outcome.DELIVERED)
            cell = Cell(run.scenario.acoustics.preset, range_m, len(own), delivered,
                        expected_delivery(config, range_m), 0)  # fmt: skip
            low, high = cell.band
            chance = binomtest(delivered, len(own), cell.expected).pvalue
            luck = (
                ""
                if cell.is_inside
                else f"; a deviation this large occurs in {100.0 * chance:.1f} % of such runs"
            )
            rows.append(
                Row(
                    f"{cell.preset}, {range_m:.0f} m, both ways: delivery ratio",
                    f"{cell.expected:.4f} (analytic)",
                    f"{delivered / cell.sent:.4f}, 95 % interval [{low:.4f}, {high:.4f}]",
                    AGREES if cell.is_inside else DIFFERS,
                    f"{delivered} of {cell.sent} packets in a TDMA cycle of {config.fleet_size} modems{luck}",
                )
            )
    return rows


def _judge_bands(runs: list[Run]) -> Verdict:
    del runs
    cells = sweep()
    outside = [cell for cell in cells if not cell.is_inside]
    # Cells with certain outcome cannot leave their interval by chance; one in twenty of the others may.
    open_cells = [cell for cell in cells if 1e-6 < cell.expected < 1.0 - 1e-6]
    allowed = int(binom.ppf(0.99, len(open_cells), 1.0 - CONFIDENCE))
    words = "; ".join(f"{cell.preset} at {cell.range_m:g} m" for cell in outside) or "none"
    evidence = (
        f"{len(cells)} cells of {min(cell.sent for cell in cells)} packets; in {len(open_cells)} of them the "
        f"outcome is uncertain; outside their 95 % interval: {words} (up to {allowed} by chance, at 99 %)"
    )
    return Verdict(HOLDS if len(outside) <= allowed else DOES_NOT_HOLD, evidence)


def _judge_reach(runs: list[Run]) -> Verdict:
    del runs
    physical = [name for name in PRESETS if medium_config(name, fleet_size=2).modem.kind == "noise_limited"]
    reach = {}
    for preset in physical:
        heard = [c.range_m for c in sweep() if c.preset == preset and c.delivered > 0.5 * c.sent]
        reach[preset] = max(heard, default=0.0)
    ends = all(
        expected_delivery(medium_config(preset, fleet_size=2), 10.0**decade) == 0.0
        for preset in physical
        for decade in range(5, 9)
    )
    words = ", ".join(f"{preset} {range_m:g} m" for preset, range_m in reach.items())
    evidence = (
        f"farthest range with more than half of the packets: {words}; "
        f"{'nothing' if ends else 'something'} arrives at 100 km and beyond"
    )
    return Verdict(
        HOLDS if ends and all(0.0 < r < RANGES_M[-1] for r in reach.values()) else DOES_NOT_HOLD, evidence
    )


FIGURES = (
    Figure(
        "A.11",
        "Delivery ratio against range for every preset of the water",
        (),
        _draw,
        "Two modems at rest, packets of 32 bytes, 5 m/s of wind where noise is modelled. Grey: analytic. "
        "Without echoes and fading the edge is a cliff, as in every model of this kind, and lies farther out "
        "than at sea; losses at shorter range are what `outage` is for.",
    ),
)

FLOWN = (
    RunSpec("range_sweep"),
    RunSpec("range_sweep", ("acoustics.preset=micromodem_psk",)),
)

TABLES = (
    Table("A.11", "Delivery ratio against range: analytic and measured", (), _rows, "formula"),
    Table(
        "A.14",
        "The range sweep flown as a scenario: six vehicles that keep station",
        FLOWN,
        _flown_rows,
        "formula",
    ),
)

CLAIMS = (
    Claim("A.11", "The medium loses as many packets as the formulas predict.", (), _judge_bands),
    Claim("A.12", "Every modem with a source level has a finite range.", (), _judge_reach),
)
