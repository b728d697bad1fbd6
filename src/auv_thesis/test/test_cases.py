"""Runs sorted by their case."""

import pytest

from auv_thesis.cases import by_case


def test_each_case_has_its_runs_in_the_order_of_the_seeds():
    assert by_case({"a": 1, "b": 2}, range(6)) == {"a": [0, 1, 2], "b": [3, 4, 5]}


def test_runs_that_cannot_be_shared_out_are_refused():
    with pytest.raises(ValueError, match="5 runs of 2 cases"):
        by_case(("a", "b"), range(5))
