"""Claims about the bytes of a report."""

import math
import struct
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_flocking.report import REPORT_BYTES, Report, ReportError, decode, encode

MODERATE = settings(max_examples=100, deadline=None)
FLOAT_32 = st.floats(-1e6, 1e6, width=32)
VECTORS = st.tuples(FLOAT_32, FLOAT_32, FLOAT_32)
REPORTS = st.builds(
    Report,
    address=st.integers(1, 255),
    sequence=st.integers(0, 2**32 - 1),
    time_s=st.floats(0.0, 1e9),
    position=VECTORS,
    velocity=VECTORS,
    centre=VECTORS,
    centre_rate=VECTORS,
    flock_velocity=VECTORS,
)
ONE = Report(3, 17, 12.5, (1.0, 2.0, 3.0), (0.1, 0.2, 0.3), (4.0, 5.0, 6.0), (0.0,) * 3, (0.01, 0.0, 0.0))


@MODERATE
@given(REPORTS)
def test_a_report_of_32_bit_numbers_survives_exactly(report):
    assert decode(encode(report)) == report


@MODERATE
@given(REPORTS, st.tuples(*[st.floats(-1000.0, 1000.0)] * 3))
def test_positions_are_rounded_to_32_bits(report, position):
    np.testing.assert_allclose(
        decode(encode(replace(report, position=position))).position, position, rtol=6e-8, atol=1e-40
    )


@MODERATE
@given(REPORTS)
def test_every_report_has_the_same_length(report):
    assert len(encode(report)) == REPORT_BYTES == 74


def test_numbers_stand_where_the_layout_says():
    payload = encode(ONE)
    assert struct.unpack_from("<BBId", payload) == (1, 3, 17, 12.5)
    assert struct.unpack_from("<3f", payload, 14) == (1.0, 2.0, 3.0)


@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=2 * REPORT_BYTES) | st.binary(min_size=REPORT_BYTES, max_size=REPORT_BYTES))
def test_random_bytes_raise_nothing_else_than_a_report_error(payload):
    _decode_or_refuse(payload)


@settings(max_examples=300, deadline=None)
@given(
    REPORTS,
    st.lists(st.tuples(st.integers(0, REPORT_BYTES - 1), st.integers(0, 255)), min_size=1, max_size=6),
)
def test_damaged_reports_raise_nothing_else_than_a_report_error(report, damage):
    payload = bytearray(encode(report))
    for index, value in damage:
        payload[index] = value
    _decode_or_refuse(bytes(payload))


def _decode_or_refuse(payload):
    """Decode; what comes out is a report of finite numbers from a real address, or a refusal."""
    try:
        report = decode(payload)
    except ReportError:
        return
    values = [getattr(report, field.name) for field in fields(report)]
    numbers = [x for value in values for x in (value if isinstance(value, tuple) else (value,))]
    assert all(map(math.isfinite, numbers))
    assert report.address >= 1


@pytest.mark.parametrize("length", [0, REPORT_BYTES - 1, REPORT_BYTES + 1])
def test_a_wrong_length_is_refused(length):
    with pytest.raises(ReportError, match=f"has {REPORT_BYTES} bytes, this has {length}"):
        decode(bytes(length))


def test_another_version_is_refused():
    with pytest.raises(ReportError, match="version 2"):
        decode(b"\x02" + encode(ONE)[1:])


def test_nobodys_address_is_refused():
    with pytest.raises(ReportError, match="address 0"):
        decode(encode(replace(ONE, address=0)))


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", ["time_s", "velocity"])
def test_numbers_that_are_not_finite_are_refused(field, number):
    value = number if field == "time_s" else (0.0, number, 0.0)
    with pytest.raises(ReportError, match="not finite"):
        decode(encode(replace(ONE, **{field: value})))
