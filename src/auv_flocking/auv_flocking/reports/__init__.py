"""
Formats of the report: how many bytes it takes and what is lost on the way.

To add one, write one file with ``Params`` and ``Format(params, shared)``, where `shared` is the sequence of
`auv_flocking.codec.Field` that the consensus filter adds to every report, with

* ``payload_bytes``: bytes of every payload, the same for all;
* ``encode(report) -> bytes``: raises `auv_flocking.report.ReportError` for numbers that cannot be sent (NaN),
  and lets values out of bounds saturate;
* ``decode(payload, now_s) -> Report``: raises `ReportError`, and nothing else, for whatever is not a report
  of this format: another length, another version, address 0, bits without a meaning; `now_s` (s) tells which
  of the possible times a wrapped time tag means;
* ``saturated``: how many values had to be bounded so far;
* ``carries: Bounds``: what it carries without saturating: a scenario that reaches beyond is refused, and a
  vehicle of a fleet whose position lies beyond holds; and
* ``position_resolution_m`` and ``velocity_resolution_mps``: steps of the sender's position and velocity (0
  where there are none to speak of), so that a filter knows what rounding adds to its noise.

Every format begins with its version in the four lowest (`exact`) or highest (`compact`) bits of the first
byte and has another length, so that none is taken for another.  A flock's vehicles use one format.
The file's name is its ``kind``.
"""

from typing import NamedTuple

from auv_core.geometry import Box


class Bounds(NamedTuple):
    """
    What a format carries without saturating.

    The sender's position (m; NED), a velocity along each axis (m/s), and along each axis the distance of the
    flocking centre from the sender (m).
    """

    position: Box
    velocity_mps: float
    centre_distance_m: float
