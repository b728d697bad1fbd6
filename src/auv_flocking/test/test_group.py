"""Claims about the vehicles of one task among others: ranks, what they have heard, kinds of reports."""

import contextlib
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_flocking.flocking import Member
from auv_flocking.group import Group, as_obstacles
from auv_flocking.heard import mask_of
from auv_flocking.lanes.status import FIELDS, STRAIGHT_ON, LaneStatus, Mode
from auv_flocking.neighbours.estimates import Estimates, NeighbourEstimate
from auv_flocking.report import Report, ReportError
from auv_flocking.report_reader import ReportReader
from auv_flocking.reports import compact, exact, lane

LANE = lane.Format(lane.Params(), FIELDS)
COMPACT = compact.Format(compact.Params(), ())
READER = ReportReader({"lane": LANE, "compact": COMPACT})
STATUS = LaneStatus(120.0, 3.0, 0.0, Mode.INLANE, False, STRAIGHT_ON, 36.0)
ZERO = (0.0, 0.0, 0.0)


def _estimate(address, *, mask=0, position=ZERO):
    covariance = np.diag([1.0, 4.0, 2.25, 1.0, 1.0, 1.0])
    return NeighbourEstimate(address, position, (1.0, 0.0, 0.0), covariance, 5.0, ZERO, ZERO, heard_mask=mask)


def _report(address, shared=()):
    return Report(
        address, 12.0, (10.0, -20.0, 30.0), (1.2, 0.5, -0.1), (10.0, -20.0, 30.0), ZERO, shared=shared
    )


def test_a_fleet_with_one_task_is_its_own_group_and_its_estimates_pass_as_they_are():
    group, estimates = Group((), 2, 3), Estimates.of([_estimate(1), _estimate(3)])
    assert group.is_all
    mates, others = group.split(estimates)
    assert mates is estimates
    assert len(others) == 0
    assert group.member(is_leader=True) == Member(True, 2, 3)


def test_vehicles_of_a_group_have_ranks_and_the_others_their_addresses():
    group = Group((2, 4, 5), 4, 6)
    mates, others = group.split(Estimates.of([_estimate(a) for a in (1, 2, 3, 5, 6)]))
    assert group.member(is_leader=False) == Member(False, 2, 3)
    assert mates.addresses == [1, 3]
    assert mates.who.tolist() == [1, 3]
    assert others.addresses == [1, 3, 6]


@given(data=st.data(), fleet_size=st.integers(2, 40))
def test_a_mask_of_ranks_claims_no_more_than_the_speaker_has_heard(data, fleet_size):
    addresses = data.draw(st.lists(st.integers(1, fleet_size), min_size=2, unique=True).map(sorted))
    speaker = data.draw(st.sampled_from(addresses))
    own = data.draw(st.sampled_from([each for each in addresses if each != speaker]))
    heard = data.draw(st.sets(st.integers(1, fleet_size)))
    mask = mask_of(dict.fromkeys(heard, 0.0), speaker, fleet_size, 0)
    (mate,), _ = Group(addresses, own, fleet_size).split(Estimates.of([_estimate(speaker, mask=mask)]))
    within = {rank: 0.0 for rank, each in enumerate(addresses, start=1) if each in heard}
    truth = mask_of(within, addresses.index(speaker) + 1, len(addresses), 0)
    assert mate.heard_mask & ~truth == 0
    if fleet_size <= 16:
        assert mate.heard_mask == truth


def test_others_are_obstacles_that_move_with_the_deviation_of_their_worst_axis():
    (one,) = as_obstacles([_estimate(3, position=(7.0, 8.0, 9.0))], 6.0)
    assert one == (3, (7.0, 8.0, 9.0), (1.0, 0.0, 0.0), 2.0, 5.0, 6.0)
    assert as_obstacles([], 6.0) == ()


def test_a_reader_of_several_formats_reads_each_by_its_version():
    from_lane = READER.decode(LANE.encode(_report(3, STATUS.numbers())), 12.0)
    from_compact = READER.decode(COMPACT.encode(_report(1)), 12.0)
    assert (from_lane.address, from_compact.address) == (3, 1)
    assert from_lane.shared[3] == Mode.INLANE
    assert from_compact.shared == ()
    for report in (from_lane, from_compact):
        assert math.dist(report.position, (10.0, -20.0, 30.0)) < 0.1
        assert math.dist(report.velocity, (1.2, 0.5, -0.1)) < 0.01


def test_a_filter_assumes_the_coarsest_of_the_formats():
    assert READER.position_resolution_m == LANE.position_resolution_m > COMPACT.position_resolution_m
    assert READER.velocity_resolution_mps == LANE.velocity_resolution_mps


@pytest.mark.parametrize(
    ("payload", "words"),
    [
        (
            exact.Format(exact.Params(), ()).encode(_report(1)),
            "version 5; the formats of this fleet read 3, 4 and 6",
        ),
        (b"", "a report of no bytes"),
        (bytes([6 << 4, 1]), "bytes"),
    ],
    ids=["another format", "nothing", "too short"],
)
def test_what_is_no_report_of_the_fleet_is_refused(payload, words):
    with pytest.raises(ReportError, match=words):
        READER.decode(payload, 0.0)


@given(payload=st.binary(max_size=40))
def test_a_reader_raises_nothing_but_a_report_error(payload):
    with contextlib.suppress(ReportError):
        READER.decode(payload, 3.0)


def test_a_velocity_that_relaxes_to_the_flocks_stays_that_of_a_vehicle_in_a_lane():
    report = LANE.decode(LANE.encode(_report(3, STATUS.numbers())), 12.0)
    assert report.flock_velocity == report.velocity
