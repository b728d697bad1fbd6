"""A recording as xarray and pandas: every array is there, named, with its unit, and described."""

import inspect
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import shoal
from auv_experiment.recording import Recording
from shoal.arrays import LABELS, MEANINGS

DESCRIPTION = (Path(__file__).parents[3] / "docs" / "reference" / "recording.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def result():
    return shoal.run("flock_acoustic", seed=3, duration_s=4.0)


def test_every_array_has_a_meaning_in_the_order_of_the_recording():
    arrays = [field.name for field in fields(Recording) if field.name not in ("vehicle_ids", "t_s")]
    assert list(MEANINGS) == arrays


def test_every_array_is_described_in_the_documents_as_it_is_named_in_the_dataset():
    for name, meaning in MEANINGS.items():
        row = f"| `{name}` | {', '.join(meaning.dims)} | {meaning.units} | {meaning.frame or '-'} |"
        assert row in DESCRIPTION
    for dim, words in LABELS.items():
        assert f"| {dim} | {', '.join(words)} |" in DESCRIPTION


def test_the_dataset_holds_the_numbers_of_the_recording(result):
    dataset, recording = result.to_xarray(), result.recording
    for name in MEANINGS:
        if name.startswith("actuator_"):
            assert name not in dataset
            continue
        values, own = dataset[name].to_numpy(), getattr(recording, name)
        np.testing.assert_array_equal(values[: len(own)], own)
        assert dataset[name].attrs["units"]
    assert dataset["time"].attrs["units"] == "s"
    assert dataset["position_ned_m"].attrs["frame"] == "map_ned"
    assert np.isnan(dataset["command"].isel(time=-1)).all()
    assert (dataset["holding"].isel(time=-1) == -1).all()


def test_the_table_has_a_row_for_each_time_and_vehicle(result):
    table = result.to_pandas()
    assert len(table) == len(result.recording.t_s) * 4
    own = table.xs("auv_3", level="vehicle")["position_ned_m.east"]
    np.testing.assert_array_equal(own, result.recording.position_ned_m[:, 2, 1])


def test_a_run_without_estimates_of_neighbours_has_none_in_its_dataset():
    dataset = shoal.run("swarm", duration_s=1.0).to_xarray()
    assert "neighbour_age_s" not in dataset
    assert "neighbour" not in dataset.coords


def test_names_of_the_interface_are_there_and_no_others():
    assert all(hasattr(shoal, name) for name in shoal.__all__)
    assert inspect.isclass(shoal.Scenario)
    with pytest.raises(AttributeError, match="no attribute 'fly'"):
        shoal.fly  # noqa: B018
