"""Near pairs by cells are those of a search over all pairs, whatever the points."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.pairs import near_pairs, no_pairs

_REACH_M = 2.0
# Coordinates on the borders of cells, near them, alike, and far outside.
_COORDINATES = st.one_of(
    st.floats(-10.0, 10.0),
    st.integers(-5, 5).map(lambda k: k * _REACH_M),
    st.integers(-5, 5).map(lambda k: float(np.nextafter(k * _REACH_M, np.inf))),
    st.sampled_from((0.0, 0.0, 1e9, -1e12, 1e300, -1e300)),
)
_CLOUDS = st.lists(st.tuples(_COORDINATES, _COORDINATES, _COORDINATES), max_size=40)


def _all_pairs(points, reach_m):
    found = []
    for i in range(len(points)):
        for j in range(i + 1, len(points)):
            dx, dy, dz = points[i] - points[j]
            if dx * dx + dy * dy + dz * dz < reach_m * reach_m:
                found.append((i, j))
    return found


def _listed(points, reach_m):
    first, partners = near_pairs(points, reach_m)
    owners = np.repeat(np.arange(len(points)), np.diff(first))
    return list(zip(owners.tolist(), partners.tolist(), strict=True))


@settings(max_examples=200, deadline=None)
@given(_CLOUDS, st.sampled_from((_REACH_M, 0.3, 7.0, 1e-3)))
def test_cells_find_the_pairs_that_a_search_over_all_finds_in_its_order(cloud, reach_m):
    points = np.array(cloud, dtype=float).reshape(-1, 3)
    with np.errstate(over="ignore", invalid="ignore"):
        assert _listed(points, reach_m) == _all_pairs(points, reach_m)


def test_many_points_in_one_place_are_all_pairs():
    points = np.zeros((50, 3))
    assert len(_listed(points, 1.0)) == 50 * 49 // 2


def test_a_point_that_is_nowhere_is_near_nobody():
    points = np.array([[0.0, 0.0, 0.0], [np.nan, 0.0, 0.0], [0.5, 0.0, 0.0], [np.inf, 0.0, 0.0]])
    with np.errstate(invalid="ignore"):
        assert _listed(points, 1.0) == [(0, 2)]


def test_no_pairs_are_none():
    first, partners = no_pairs(np.zeros((5, 3)), 1.0)
    assert len(first) == 6
    assert not first.any()
    assert not len(partners)
