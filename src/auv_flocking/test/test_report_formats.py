"""Claims about the bytes of a report, in every format of the folder."""

import json
import math
import random
import struct
from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.plugins import find_plugin, list_plugins
from auv_flocking.codec import Field, field_table
from auv_flocking.consensus import pi, push_sum, thesis
from auv_flocking.lanes.status import FIELDS
from auv_flocking.report import NEVER, Report, ReportError
from auv_flocking.reports import VERSIONS, compact, exact, lane

MODERATE = settings(max_examples=100, deadline=None)
SHARED = (Field("sum", -8.0, 8.0, 2.0**-10, wraps=True), Field("weight", 0.0, 1.0, 0.125))
KINDS = list_plugins("auv_flocking.reports")
EVERY = pytest.mark.parametrize("kind", KINDS)

FLOAT_32 = st.floats(-1e6, 1e6, width=32)
VECTORS = st.tuples(FLOAT_32, FLOAT_32, FLOAT_32)
EXACT_REPORTS = st.builds(
    lambda report, age_s: report._replace(flock_stamp_s=report.time_s - age_s),
    st.builds(
        Report,
        address=st.integers(1, 255),
        time_s=st.floats(0.0, 1e9),
        position=VECTORS,
        velocity=VECTORS,
        centre=VECTORS,
        flock_velocity=VECTORS,
        flock_turn_rate_radps=FLOAT_32,
        heading_rad=FLOAT_32,
        position_sd_m=st.floats(0.0, 100.0, width=32),
        is_bounded=st.booleans(),
        is_holding=st.booleans(),
        heard_code=st.integers(0, 15),
        heard_mask=st.integers(0, 2**16 - 1),
        shared=st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)),
    ),
    st.floats(0.0, 1e3) | st.just(math.inf),
)


def _vector(bound):
    return st.tuples(*[st.floats(-bound, bound)] * 3)


def _velocity():
    return st.tuples(*[st.floats(-2.55, 2.55)] * 2, st.floats(-1.27, 1.27))


COMPACT_REPORTS = st.builds(
    lambda report, offset, age_s: report._replace(
        centre=tuple(np.add(report.position, offset).tolist()),
        flock_stamp_s=report.time_s - age_s,
    ),
    st.builds(
        Report,
        address=st.integers(1, 255),
        time_s=st.floats(0.0, 1e5),
        position=st.tuples(st.floats(-5242.0, 5242.0), st.floats(-5242.0, 5242.0), st.floats(-10.0, 645.0)),
        velocity=_velocity(),
        centre=st.just((0.0, 0.0, 0.0)),
        flock_velocity=_velocity(),
        flock_turn_rate_radps=st.floats(-0.128, 0.127),
        heading_rad=st.floats(-10.0, 10.0),
        position_sd_m=st.just(0.0) | st.floats(2.0**-8, 230.0),
        is_bounded=st.booleans(),
        is_holding=st.booleans(),
        heard_code=st.integers(0, 15),
        heard_mask=st.integers(0, 2**16 - 1),
        shared=st.tuples(st.floats(-7.99, 7.99), st.floats(0.0, 1.0)),
    ),
    _vector(81.8),
    st.floats(0.0, 163.8) | st.just(math.inf),
)
ONE = Report(
    3,
    12.5,
    (1.0, 2.0, 3.0),
    (0.1, 0.2, 0.3),
    (4.0, 5.0, 6.0),
    (0.01, 0.0, 0.0),
    12.0,
    0.01,
    2.0,
    0.5,
    is_bounded=True,
    heard_code=5,
    heard_mask=0b1011,
)
ONE_SHARED = ONE._replace(shared=(1.0, 0.5))


def _format(kind, shared=()):
    module = find_plugin("auv_flocking.reports", kind)
    return module.Format(module.Params(), shared)


@MODERATE
@given(EXACT_REPORTS)
def test_exact_gives_a_report_of_32_bit_numbers_back_as_it_was(report):
    form = _format("exact", SHARED)
    assert form.decode(form.encode(report), 0.0) == report
    assert form.saturated == 0


@MODERATE
@given(EXACT_REPORTS, st.tuples(*[st.floats(-1000.0, 1000.0)] * 3))
def test_exact_rounds_positions_to_32_bits(report, position):
    form = _format("exact", SHARED)
    back = form.decode(form.encode(report._replace(position=position)), 0.0)
    np.testing.assert_allclose(back.position, position, rtol=6e-8, atol=1e-40)


def test_exact_numbers_stand_where_the_layout_says():
    payload = _format("exact", SHARED).encode(ONE_SHARED)
    assert struct.unpack_from("<BBBBBHHBd", payload) == (0x50, 3, 1, 0, 5, 0b1011, 0, 0, 12.5)
    assert struct.unpack_from("<3f", payload, 18) == (1.0, 2.0, 3.0)
    assert struct.unpack_from("<d3f2d", payload, 66) == (12.0, np.float32(0.01), 2.0, 0.5, 1.0, 0.5)
    assert len(payload) == 102


def test_exact_saturates_what_no_vehicle_can_mean():
    form = _format("exact")
    report = form.decode(form.encode(ONE._replace(velocity=(1e300, -math.inf, 0.0), flock_stamp_s=13.0)), 0.0)
    assert report.velocity == (1e9, -1e9, 0.0)
    assert report.flock_stamp_s == report.time_s == 12.5
    assert form.saturated == 3


@MODERATE
@given(COMPACT_REPORTS, st.floats(-327.0, 327.0))
def test_compact_is_right_to_half_a_resolution(report, later_s):
    """Of every number; the centre and the stamp, which are sent as differences, included."""
    form = _format("compact", SHARED)
    back = form.decode(form.encode(report), report.time_s + later_s)
    for name in ("address", "is_bounded", "is_holding", "heard_code", "heard_mask"):
        assert getattr(back, name) == getattr(report, name)
    for name, half in (
        ("time_s", 0.005),
        ("position", 0.01),
        ("velocity", 0.00125),
        ("centre", 0.04),
        ("flock_velocity", 0.0025),
        ("flock_turn_rate_radps", 0.0005),
    ):
        error = np.abs(np.subtract(getattr(back, name), getattr(report, name))).max()
        assert error <= half * (1.0 + 1e-6), name
    off_rad = math.remainder(back.heading_rad - report.heading_rad, 2.0 * math.pi)
    assert abs(off_rad) <= math.pi / 128.0 * (1.0 + 1e-6)
    assert back.position_sd_m == pytest.approx(report.position_sd_m, rel=2.0 ** (1.0 / 32.0) - 1.0 + 1e-9)
    assert abs(back.shared[0] - report.shared[0]) <= 2.0**-11
    assert abs(back.shared[1] - report.shared[1]) <= 2.0**-4
    if report.flock_stamp_s == NEVER:
        assert back.flock_stamp_s == NEVER
    else:
        assert abs(back.flock_stamp_s - report.flock_stamp_s) <= 0.005 * (1.0 + 1e-5)
    assert form.saturated == 0


def test_compact_fits_a_micromodem_frame():
    form = _format("compact")
    assert form.payload_bytes == len(form.encode(ONE)) == 32
    assert sum(field.bits for field in form.fields) == 256
    assert _format("compact", SHARED).payload_bytes == 35


@MODERATE
@given(st.floats(0.01, 100.0), st.floats(0.0, 0.01), st.floats(1.0, 1.04))
def test_compact_rounding_neither_feigns_a_fix_nor_hides_one(sd_m, fall, growth):
    """A receiver takes a deviation below 0.95 times the last one for a fix."""
    form = _format("compact")

    def sent(value_m):
        return form.decode(form.encode(ONE._replace(position_sd_m=value_m)), 12.5).position_sd_m

    assert sent(sd_m * growth) >= sent(sd_m) > 0.0
    assert sent(sd_m * (1.0 - fall)) >= 0.95 * sent(sd_m)
    assert sent(sd_m * 0.9) < 0.95 * sent(sd_m)


def test_compact_never_calls_a_navigation_with_an_error_exact():
    form = _format("compact")
    report = form.decode(form.encode(ONE._replace(position_sd_m=1e-9)), 12.5)
    assert report.position_sd_m == 2.0**-8
    assert form.saturated == 0


def test_reserved_bits_are_zero_and_are_refused_otherwise():
    """After the bits of the report, in both formats."""
    packed = int.from_bytes(_format("compact").encode(ONE), "big")
    assert packed % 2**20 == 0
    for bit in range(20):
        with pytest.raises(ReportError, match="operator_"):
            _format("compact").decode((packed | 1 << bit).to_bytes(32, "big"), 12.5)
    payload = _format("exact").encode(ONE)
    for place, damage in ((0, 0x01), (2, 0x02), (3, 0x02), (4, 0x10), (7, 0x01), (8, 0x80), (9, 0x01)):
        damaged = bytes((*payload[:place], payload[place] ^ damage, *payload[place + 1 :]))
        with pytest.raises(ReportError, match="without a meaning"):
            _format("exact").decode(damaged, 12.5)


def test_a_time_tag_of_three_minutes_ago_is_read_as_such():
    form = _format("compact")
    for now_s in (192.5, 12.5 + 327.0):
        assert form.decode(form.encode(ONE), now_s).time_s == 12.5
    assert form.decode(form.encode(ONE), 12.5 + 328.0).time_s == 12.5 + 655.36, "the limit: 327.68 s"


def test_compact_stamps_are_passed_on_without_a_change():
    """From vehicle to vehicle, each a few control periods of 0.1 s later."""
    form = _format("compact")
    stamp_s = 601.3
    for hop in range(1, 40):
        tick = 6013 + 7 * hop
        stamp_s = form.decode(
            form.encode(ONE._replace(time_s=tick * 0.1, flock_stamp_s=stamp_s)), tick * 0.1 + 2.0
        ).flock_stamp_s
    assert stamp_s == pytest.approx(601.3, abs=1e-9)


def test_compact_ages_end_at_their_maximum():
    form = _format("compact")
    old = form.decode(form.encode(ONE._replace(time_s=1000.0, flock_stamp_s=3.0)), 1001.0)
    assert old.flock_stamp_s == pytest.approx(1000.0 - 163.82)
    newer = form.decode(form.encode(ONE._replace(flock_stamp_s=13.0)), 12.5)
    assert newer.flock_stamp_s == 12.5
    assert form.saturated == 2


def test_compact_counts_what_is_out_of_bounds():
    form = _format("compact")
    far = ONE._replace(position=(6000.0, 0.0, -500.0), centre=(5300.0, 90.0, 60.0))
    back = form.decode(form.encode(far), 12.5)
    assert form.saturated == 3
    assert back.position == pytest.approx((5242.86, 0.0, -10.24))
    assert back.centre == pytest.approx((5300.0, 81.88, 60.0), abs=0.04)


def test_compact_resolutions_can_be_chosen():
    form = compact.Format(compact.Params(position_resolution_m=0.1), ())
    assert form.payload_bytes == 32
    back = form.decode(form.encode(ONE._replace(position=(26000.0, -26000.0, 3200.0))), 12.5)
    assert back.position == pytest.approx((26000.0, -26000.0, 3200.0), abs=0.05)


@EVERY
@MODERATE
@given(COMPACT_REPORTS)
def test_every_report_has_the_stated_length(kind, report):
    form = _format(kind, SHARED)
    assert len(form.encode(report)) == form.payload_bytes


@EVERY
@pytest.mark.parametrize("shared", [(), SHARED], ids=["alone", "shared"])
def test_the_bits_of_every_field_are_those_of_the_payload(kind, shared):
    form = _format(kind, shared)
    names = [name for name, _ in form.budget]
    assert len(set(names)) == len(names)
    padding = 8 * form.payload_bytes - sum(bits for _, bits in form.budget)
    assert 0 <= padding < 8


@EVERY
@pytest.mark.parametrize(
    "change",
    [
        {"time_s": math.nan},
        {"time_s": math.nan, "flock_stamp_s": NEVER},
        {"position": (0.0, math.nan, 0.0)},
        {"centre": (math.nan, 0.0, 0.0)},
        {"flock_stamp_s": math.nan},
        {"position_sd_m": math.nan},
        {"heading_rad": math.nan},
        {"flock_turn_rate_radps": math.nan},
        {"is_bounded": None},
        {"is_holding": None},
        {"heard_code": 16},
        {"heard_mask": 2**16},
        {"heard_mask": None},
        {"address": 0},
        {"address": 256},
        {"shared": ()},
        {"shared": (math.nan, 0.0)},
    ],
)
def test_what_cannot_be_sent_is_refused(kind, change):
    with pytest.raises(ReportError):
        _format(kind, SHARED).encode(ONE_SHARED._replace(**change))


@EVERY
@settings(max_examples=300, deadline=None)
@given(st.data())
def test_random_bytes_raise_nothing_else_than_a_report_error(kind, data):
    form = _format(kind, SHARED)
    size = form.payload_bytes
    payload = data.draw(st.binary(max_size=2 * size) | st.binary(min_size=size, max_size=size))
    _decode_or_refuse(form, payload)


@EVERY
@settings(max_examples=300, deadline=None)
@given(st.data())
def test_damaged_reports_raise_nothing_else_than_a_report_error(kind, data):
    form = _format(kind, SHARED)
    payload = bytearray(form.encode(ONE_SHARED))
    for _ in range(data.draw(st.integers(1, 6))):
        payload[data.draw(st.integers(0, len(payload) - 1))] = data.draw(st.integers(0, 255))
    _decode_or_refuse(form, bytes(payload))


@pytest.mark.slow
@pytest.mark.timeout(900)
@EVERY
def test_a_million_random_payloads_raise_nothing_else_than_a_report_error(kind):
    """
    A tenth of them of any length; every other one a report of which a random part, often none of its start,
    is random.
    """
    form, rng = _format(kind, SHARED), random.Random(11)
    sound = form.encode(ONE_SHARED)
    read = 0
    for index in range(1_000_000):
        if index % 10 == 0:
            payload = rng.randbytes(rng.randrange(2 * form.payload_bytes))
        else:
            payload = rng.randbytes(form.payload_bytes)
        if index % 2:
            start, end = sorted((rng.randrange(form.payload_bytes), rng.randrange(form.payload_bytes)))
            payload = sound[:start] + payload[start:end] + sound[end:]
        read += _decode_or_refuse(form, payload)
    assert read > 100


def _decode_or_refuse(form, payload):
    """Decode; what comes out is a report of finite numbers from a real address, or a refusal."""
    try:
        report = form.decode(payload, 100.0)
    except ReportError:
        return False
    stamp_s = report.flock_stamp_s
    vectors = (report.position, report.velocity, report.centre, report.flock_velocity)
    total = sum(map(sum, vectors)) + sum(report.shared) + report.time_s + report.position_sd_m
    if report.is_bounded is not None:
        total += report.heading_rad + report.flock_turn_rate_radps
    assert stamp_s == NEVER or math.isfinite(stamp_s)
    assert math.isfinite(total)
    assert report.address >= 1
    assert stamp_s <= report.time_s
    assert report.position_sd_m >= 0.0
    assert len(report.shared) == len(SHARED)
    return True


@EVERY
def test_a_wrong_length_is_refused(kind):
    form = _format(kind)
    size = form.payload_bytes
    for length in (0, size - 1, size + 1):
        with pytest.raises(ReportError, match=f"has {size} bytes, this has {length}"):
            form.decode(form.encode(ONE)[:length] + bytes(max(0, length - size)), 0.0)


@EVERY
def test_another_version_is_refused(kind):
    form = _format(kind)
    payload = form.encode(ONE)
    for flipped in (0x11, 0x22):
        with pytest.raises(ReportError, match="version"):
            form.decode(bytes((payload[0] ^ flipped,)) + payload[1:], 0.0)


def test_no_format_reads_another():
    for one, other in pairwise([*KINDS, KINDS[0]]):
        with pytest.raises(ReportError):
            _format(one).decode(_format(other).encode(ONE), 12.5)


def test_nobodys_address_is_refused():
    payload = bytearray(_format("exact").encode(ONE))
    payload[1] = 0
    with pytest.raises(ReportError, match="address 0"):
        _format("exact").decode(bytes(payload), 12.5)
    payload = bytearray(_format("compact").encode(ONE))
    payload[0] &= 0xF0
    payload[1] &= 0x0F
    with pytest.raises(ReportError, match="address 0"):
        _format("compact").decode(bytes(payload), 12.5)


def test_every_kind_has_versions_and_no_two_kinds_share_one():
    assert VERSIONS.keys() == set(KINDS)
    counted = Counter(number for each in VERSIONS.values() for number in (each.written, *each.older))
    assert set(counted.values()) == {1}
    assert all(0 <= number < 16 for number in counted)


@EVERY
def test_every_payload_begins_with_its_version(kind):
    assert _format(kind).encode(ONE)[0] >> 4 == VERSIONS[kind].written


def test_reports_of_older_versions_are_read():
    """`reports_before.json`: payloads and their numbers, made by the last code that sent these versions."""
    cases = json.loads((Path(__file__).parent / "reports_before.json").read_text(encoding="utf-8"))
    filters = {"none": (), "pi": pi.Consensus(pi.Params(), 4).shared_fields}
    for case in cases:
        report = _format(case["kind"], filters[case["shared"]]).decode(
            bytes.fromhex(case["payload"]), case["now_s"]
        )
        for name in ("address", "time_s", "flock_stamp_s", "position_sd_m"):
            assert getattr(report, name) == (NEVER if case[name] is None else case[name])
        for name in ("position", "velocity", "centre", "flock_velocity"):
            assert list(getattr(report, name)) == case[name]
        assert list(report.shared) == case["shared_numbers"]
        assert math.isnan(report.heading_rad)
        assert math.isnan(report.flock_turn_rate_radps)
        unknown = (report.is_bounded, report.is_holding, report.heard_code, report.heard_mask)
        assert set(unknown) == {None}
    assert Counter(case["kind"] for case in cases) == {"compact": 6, "exact": 6}


def test_the_rate_of_the_centre_in_older_reports_is_what_the_filter_shares_today():
    cases = json.loads((Path(__file__).parent / "reports_before.json").read_text(encoding="utf-8"))
    fields = thesis.Consensus(thesis.Params(carried_by="rate"), 4).shared_fields
    for case in cases:
        if case["shared"] == "none":
            form = _format(case["kind"], fields)
            report = form.decode(bytes.fromhex(case["payload"]), case["now_s"])
            assert list(report.shared) == case["centre_rate"]


def _budget_table(kind):
    form = _format(kind)
    rows = [f"| `{name}` | {bits} |" for name, bits in form.budget]
    total = f"| of {8 * form.payload_bytes} | {sum(bits for _, bits in form.budget)} |"
    return [f"| `{kind}` | bits |", "|---|---|", *rows, total]


def test_the_page_on_packets_shows_the_fields_as_they_are():
    page = (Path(__file__).parents[3] / "docs" / "reference" / "packets.md").read_text(encoding="utf-8")
    layouts = [compact.Format(compact.Params(), ()).fields, lane.Format(lane.Params(), ()).fields, FIELDS]
    layouts += [module.Consensus(module.Params(), 4).shared_fields for module in (thesis, pi, push_sum)]
    for layout in layouts:
        assert "\n".join(field_table(layout)) in page
    for kind in KINDS:
        assert "\n".join(_budget_table(kind)) in page
    filters = [each.Consensus(each.Params(), 4) for each in (thesis, pi, push_sum)]
    for module in (compact, exact):
        forms = [
            module.Format(module.Params(), shared) for shared in ((), *(f.shared_fields for f in filters))
        ]
        alone, *more = (form.payload_bytes for form in forms)
        words = f"{alone}, with `thesis` {more[0]}, with `pi` {more[1]}, with `push_sum` {more[2]}"
        assert words in page


def test_a_lane_fills_32_bytes():
    form = lane.Format(lane.Params(), FIELDS)
    assert form.payload_bytes == 32
    assert sum(bits for _, bits in form.budget) == 256


@MODERATE
@given(COMPACT_REPORTS, st.floats(-1e5, 1e5), st.integers(0, 12), st.booleans())
def test_a_lane_gives_position_and_status_back(report, gamma_m, course, is_limited):
    form = lane.Format(lane.Params(), FIELDS)
    shared = (gamma_m, 0.1 * gamma_m, -0.5, 2.0, float(is_limited), float(course), 30.5)
    sent = report._replace(shared=shared)
    back = form.decode(form.encode(sent), sent.time_s + 60.0)
    np.testing.assert_allclose(back.position, sent.position, atol=0.02501)
    np.testing.assert_allclose(back.velocity, sent.velocity, atol=0.002501)
    np.testing.assert_allclose(back.shared, shared, atol=0.02501)
    assert back.time_s == pytest.approx(sent.time_s, abs=0.00501)
    assert (back.centre, back.flock_velocity, back.flock_stamp_s) == (back.position, back.velocity, NEVER)
    assert form.saturated == 0
