"""
The Bellhop solver as a separate program: a case comes in as JSON, arrivals go out as npz.

`bellhop` starts it by its path, and it imports nothing of this project. So a solver that hangs or dies does
no harm to a run, and the library, which has its own licence, is never loaded into a run.
"""

from __future__ import annotations

import io
import json
import sys

import numpy as np


def main() -> None:
    """
    Solve one case.

    The arrays are `arrival_offset` (place k has the arrivals from its k-th entry up to the next; depths vary
    fastest, then ranges), `amplitude`, `phase_rad` and `time_s`.
    """
    import pelagic

    found = pelagic.bellhop.Case.from_dict(json.load(sys.stdin)).run().arrivals
    if np.any(np.diff(found.ranges_m) < 0.0):
        raise RuntimeError("the solver gave its ranges in an order that this program does not know")
    result = io.BytesIO()
    np.savez(
        result,
        arrival_offset=np.asarray(found.arrival_offset, dtype=np.int64),
        amplitude=np.asarray(found.amplitude, dtype=np.float64),
        phase_rad=np.asarray(found.phase_radians, dtype=np.float64),
        time_s=np.asarray(found.travel_time_s, dtype=np.float64),
    )
    sys.stdout.buffer.write(result.getvalue())


if __name__ == "__main__":
    main()
