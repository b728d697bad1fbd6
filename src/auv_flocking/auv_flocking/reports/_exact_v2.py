"""
Version 2 of `exact`, which older recordings contain; nothing is sent in it.

Its first byte is 2. It has a sequence number and the rate of the centre in every report, and neither heading,
turn rate of the flock velocity, `is_bounded`, `is_holding` nor what the sender has heard.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

from auv_flocking.codec import Field
from auv_flocking.report import Report, ReportError

_FIRST_BYTE = 2
_RATES = tuple(f"centre_rate_{axis}_mps" for axis in ("north", "east", "down"))


class Reader:
    """
    Decodes reports of version 2.

    Parameters
    ----------
    shared : sequence of Field
        The fields that the consensus filter adds today. The rate of the centre is not added in this version,
        since every report has it.

    """

    def __init__(self, shared: Sequence[Field]) -> None:
        self._names = [field.name for field in shared]
        self._added = [name for name in self._names if name not in _RATES]
        self._layout = struct.Struct(f"<BBId15fdf{len(self._added)}d")

    def decode(self, payload: bytes) -> Report:
        """Return the report, with its numbers unchecked; raise `ReportError` for another length or byte."""
        if len(payload) != self._layout.size:
            raise ReportError(f"a report has {self._layout.size} bytes, this has {len(payload)}")
        first, address, _, time_s, *v = self._layout.unpack(payload)
        if first != _FIRST_BYTE:
            raise ReportError(f"the first byte is {first}; allowed in version 0: {_FIRST_BYTE}")
        p, u, c, r, w = [(v[i], v[i + 1], v[i + 2]) for i in range(0, 15, 3)]
        numbers = dict(zip((*_RATES, *self._added), (*r, *v[17:]), strict=True))
        return Report(
            address,
            time_s,
            p,
            u,
            c,
            w,
            v[15],
            flock_turn_rate_radps=math.nan,
            heading_rad=math.nan,
            position_sd_m=v[16],
            is_bounded=None,
            is_holding=None,
            heard_code=None,
            heard_mask=None,
            shared=tuple([numbers[name] for name in self._names]),
        )
