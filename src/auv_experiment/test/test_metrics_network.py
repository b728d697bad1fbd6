"""Claims about the communication graph, from packets made by hand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from auv_experiment.metrics.network import (
    algebraic_connectivity,
    heard_graphs,
    laplacian,
    network_metrics,
    strong_parts,
)
from auv_experiment.recording import Recording
from auv_experiment.scenario.loading import load_scenario

IDS = ("auv_1", "auv_2", "auv_3", "auv_4")
EVERYBODY = [(i, j) for i in range(1, 5) for j in range(1, 5) if i != j]
ADJACENCIES = st.integers(2, 7).flatmap(
    lambda n: arrays.arrays(bool, (n, n)).map(lambda a: a & ~np.eye(n, dtype=bool))
)


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("flock_acoustic")


def _recording(packets, duration_s=200.0, delay_s=0.5, lost=()):
    """Return a recording of four vehicles; `packets` are (time of arrival, source, destination)."""
    recording = Recording.empty(IDS, 0.5 * np.arange(2 * round(duration_s) + 1))
    rows = [(round(2 * t_s), source, destination, k) for k, (t_s, source, destination) in enumerate(packets)]
    lost_at_s = np.full(4, np.nan)
    for index, at_s in lost:
        lost_at_s[index] = at_s
    return replace(
        recording,
        received=np.array(rows, dtype=np.int64).reshape(-1, 4),
        delay_s=np.full(len(rows), delay_s),
        lost_at_s=lost_at_s,
    )


def _every_10_s(links, start_s=10.0, end_s=200.0):
    return [(t, *link) for t in np.arange(start_s, end_s, 10.0) for link in links]


def test_a_flock_that_hears_itself_is_connected(scenario):
    m = network_metrics(_recording(_every_10_s(EVERYBODY)), scenario)
    assert m == {
        "graph_window_s": 30.0,
        "graph_connected_at_s": 10.0,
        "graph_disconnected_at_s": None,
        "graph_strongly_connected_ratio": pytest.approx(191 / 201),
        "graph_algebraic_connectivity_mean": pytest.approx(4.0),
        "graph_algebraic_connectivity_min": pytest.approx(4.0),
        "graph_degree_mean": 3.0,
        "graph_in_degree_min": 3,
        "graph_out_degree_min": 3,
        "graph_parts_max": 1,
    }


def test_a_flock_in_two_halves_is_reported_and_not_hidden(scenario):
    halves = [(1, 2), (2, 1), (3, 4), (4, 3)]
    m = network_metrics(_recording(_every_10_s(halves)), scenario)
    assert m["graph_connected_at_s"] is None
    assert m["graph_disconnected_at_s"] == 0.0
    assert m["graph_strongly_connected_ratio"] == 0.0
    assert m["graph_algebraic_connectivity_mean"] == m["graph_algebraic_connectivity_min"] == 0.0
    assert m["graph_parts_max"] == 4
    assert m["graph_in_degree_min"] == 0


def test_a_flock_that_falls_apart_is_reported_with_the_time(scenario):
    """After 100 s no vehicle hears auv_4; its packet of 90 s was sent at 89.5 s and counts up to 119.5 s."""
    packets = _every_10_s(EVERYBODY, end_s=100.0) + _every_10_s(
        [link for link in EVERYBODY if link[0] != 4], start_s=100.0
    )
    m = network_metrics(_recording(packets), scenario)
    assert m["graph_connected_at_s"] == 10.0
    assert m["graph_disconnected_at_s"] == 120.0
    assert m["graph_strongly_connected_ratio"] == pytest.approx(110 / 201)
    assert m["graph_algebraic_connectivity_min"] == pytest.approx(2.0), "one way is half a link in the mirror"
    assert (m["graph_in_degree_min"], m["graph_out_degree_min"], m["graph_parts_max"]) == (2, 0, 2)


def test_a_silent_flock_is_disconnected_too(scenario):
    m = network_metrics(_recording([]), scenario)
    assert (m["graph_connected_at_s"], m["graph_disconnected_at_s"], m["graph_parts_max"]) == (None, 0.0, 4)


def test_a_lost_vehicle_leaves_the_graph(scenario):
    packets = _every_10_s(EVERYBODY, end_s=100.0) + _every_10_s(
        [link for link in EVERYBODY if 4 not in link], start_s=100.0
    )
    m = network_metrics(_recording(packets, lost=[(3, 95.0)]), scenario)
    assert m["graph_disconnected_at_s"] is None
    assert m["graph_algebraic_connectivity_min"] == pytest.approx(3.0)
    assert m["graph_in_degree_min"] == 2


def test_a_flock_of_one_survivor_has_no_graph_any_more(scenario):
    m = network_metrics(_recording([], lost=[(0, 0.0), (1, 0.0), (2, 0.0)]), scenario)
    assert set(m.values()) == {None}


def test_without_packets_by_design_there_is_nothing_to_say(scenario):
    alone = Recording.empty(("auv_1",), np.arange(11.0))
    assert network_metrics(alone, scenario) == {}
    assert network_metrics(_recording([]), load_scenario("ch5_one_leader")) == {}


def test_an_edge_lasts_from_the_arrival_until_the_packet_is_a_window_old():
    graphs = heard_graphs(_recording([(10.0, 1, 2)], delay_s=4.0), window_s=7.0)
    heard_s = graphs.t_s[graphs.adjacency[:, 1, 0]]
    np.testing.assert_array_equal(heard_s, [10.0, 11.0, 12.0, 13.0])
    assert graphs.adjacency.sum() == 4


def test_a_late_packet_does_not_shorten_what_a_newer_one_gave():
    early = _recording([(10.0, 1, 2), (12.0, 1, 2)])
    early.delay_s[:] = (1.0, 9.0)
    graphs = heard_graphs(early, window_s=5.0)
    np.testing.assert_array_equal(graphs.t_s[graphs.adjacency[:, 1, 0]], [10.0, 11.0, 12.0, 13.0, 14.0])


@settings(max_examples=100, deadline=None)
@given(ADJACENCIES)
def test_laplacian_rows_sum_to_zero(adjacency):
    np.testing.assert_allclose(laplacian(adjacency).sum(axis=1), 0.0)
    np.testing.assert_allclose(np.diag(laplacian(adjacency)), adjacency.sum(axis=1))


@settings(max_examples=100, deadline=None)
@given(ADJACENCIES)
def test_parts_and_connectivity_agree_with_a_search(adjacency):
    n = len(adjacency)
    alive = np.ones((1, n), dtype=bool)
    reach = [_reached(adjacency, start) for start in range(n)]
    parts = {frozenset(j for j in reach[i] if i in reach[j]) for i in range(n)}
    assert strong_parts(adjacency[np.newaxis], alive)[0] == len(parts)
    mirror = adjacency | adjacency.T
    lambda_2 = algebraic_connectivity(adjacency[np.newaxis], alive)[0]
    assert (lambda_2 > 1e-9) == (len(_reached(mirror, 0)) == n)


def _reached(adjacency, start):
    found, new = {start}, [start]
    while new:
        i = new.pop()
        for j in np.flatnonzero(adjacency[i]).tolist():
            if j not in found:
                found.add(j)
                new.append(j)
    return found


@pytest.mark.parametrize(
    ("edges", "expected"),
    [
        ([(0, 1), (1, 2), (2, 3), (3, 0)], 2.0),
        ([(0, 1), (1, 2), (2, 3)], 2.0 - np.sqrt(2.0)),
        ([(0, 1), (0, 2), (0, 3)], 1.0),
    ],
)
def test_connectivity_of_rings_chains_and_stars_is_as_in_the_books(edges, expected):
    adjacency = np.zeros((1, 4, 4), dtype=bool)
    for i, j in edges:
        adjacency[0, i, j] = adjacency[0, j, i] = True
    assert algebraic_connectivity(adjacency, np.ones((1, 4), dtype=bool)) == pytest.approx(expected)
