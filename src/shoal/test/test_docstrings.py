"""The examples in the docstrings of the Python interface hold."""

import doctest
import importlib

import pytest

MODULES = ("shoal", "shoal.runs", "shoal.result", "shoal.scenario", "shoal.simulation")
PUBLIC = {
    "shoal.runs": {"run", "sweep"},
    "shoal.result": {"Result", "Result.figure", "Result.to_pandas", "Result.to_xarray", "open_result"},
    "shoal.scenario": {"Scenario", "load", "scenarios"},
    "shoal.simulation": {"Simulation"},
}


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_hold(name):
    failed, tried = doctest.testmod(importlib.import_module(name), optionflags=doctest.ELLIPSIS)
    assert tried
    assert not failed


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_what_is_public_has_an_example(name):
    found = doctest.DocTestFinder().find(importlib.import_module(name), name)
    with_examples = {each.name.removeprefix(f"{name}.") for each in found if each.examples}
    assert PUBLIC[name] <= with_examples
