"""Checks the packets that an agent's modem received: accepted reports, and refusals by sender."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from auv_core.messages import Packet
from auv_flocking.input_limits import InputLimits
from auv_flocking.report import Report, ReportError
from auv_flocking.reports import ReportDecoder

_CLOCK_SLACK_S = 1.0


@dataclass(slots=True)
class Refusal:
    """Why packets of one sender are refused, since when (s), and how many in a row."""

    words: str
    since_s: float
    packets: int


def why_refused(report: Report, own_address: int, fleet_size: int, limits: InputLimits, t_s: float) -> str:
    """Return why a report is not from another vehicle of the fleet in this run, or an empty text."""
    if report.address == own_address:
        return "it has this vehicle's own address"
    if report.address > fleet_size:
        return f"address {report.address}, allowed: 1 to {fleet_size}"
    if report.time_s > t_s + _CLOCK_SLACK_S:
        return f"time tag {report.time_s - t_s:.1f} s in the future, allowed: {_CLOCK_SLACK_S:g} s"
    if report.time_s < 0.0:
        return f"time tag {-report.time_s:.1f} s before the start of the run"
    farthest_m = max(map(abs, (*report.position, *report.centre)))
    if farthest_m > limits.position_max_m:
        return f"a place {farthest_m:.3g} m from the origin, allowed: {limits.position_max_m:g} m"
    speed_mps, speed_max_mps = math.hypot(*report.velocity), limits.largest_speed_mps
    if speed_mps > speed_max_mps:
        return f"speed {speed_mps:.3g} m/s, allowed: {speed_max_mps:.3g} m/s"
    return ""


class PacketJudge:
    """
    Decodes and checks packets.

    `rejected` counts the refused packets; `refusals` has, by the sender's address, why its newest packet was
    refused, until one is accepted again.
    """

    def __init__(
        self, decoder: ReportDecoder, own_address: int, fleet_size: int, limits: InputLimits
    ) -> None:
        self._decoder = decoder
        self._own_address = own_address
        self._fleet_size = fleet_size
        self._limits = limits
        self.rejected = 0
        self.refusals: dict[int, Refusal] = {}

    def reports(self, t_s: float, packets: Iterable[Packet]) -> list[Report]:
        """Return the accepted reports of the packets received until `t_s` (s), in the order of arrival."""
        good = []
        for packet in packets:
            report, words = self._read(t_s, packet)
            if report is None:
                self._refuse(packet.source, words, t_s)
            else:
                self.refusals.pop(report.address, None)
                good.append(report)
        return good

    def _read(self, t_s: float, packet: Packet) -> tuple[Report | None, str]:
        try:
            report = self._decoder.decode(packet.payload, t_s)
        except ReportError as error:
            return None, str(error)
        if report.address != packet.source:
            return None, f"its report has address {report.address}"
        words = why_refused(report, self._own_address, self._fleet_size, self._limits, t_s)
        return (None, words) if words else (report, "")

    def _refuse(self, source: int, words: str, t_s: float) -> None:
        self.rejected += 1
        refusal = self.refusals.setdefault(source, Refusal(words, t_s, 0))
        refusal.words = words
        refusal.packets += 1


def refusal_words(refusals: dict[int, Refusal], fleet_ids: Sequence[str], t_s: float) -> list[str]:
    """
    Return a line for every sender whose packets are refused at `t_s` (s): name, reason, duration, number.
    """
    return [
        f"{vehicle_name(address, fleet_ids)}: {refusal.words}, for {t_s - refusal.since_s:.1f} s, "
        f"{refusal.packets} packet{'s' if refusal.packets > 1 else ''}"
        for address, refusal in sorted(refusals.items())
    ]


def vehicle_name(address: int, fleet_ids: Sequence[str]) -> str:
    """Return the name of the vehicle with an acoustic address, or the address if no name is known."""
    return fleet_ids[address - 1] if 0 < address <= len(fleet_ids) else f"address {address}"
