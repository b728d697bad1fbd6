"""The programs of `examples/` run, and state their purpose."""

import importlib.util
from pathlib import Path

import pytest

import auv_flocking.separation

EXAMPLES = Path(__file__).parents[1] / "examples"
PROGRAMS = sorted(EXAMPLES.glob("*.py"))
SAYS = {
    "allocate_thrusters": "odin, thruster 1 lost: X 185.3, Y 185.3, Z 524.0",
    "environment": "13 numbers observed; total reward",
    "fly": "smallest distance: 1.",
    "own_law": "steep: smallest distance",
    "plot_a_run": "written: depths.png",
    "push_a_vehicle": "auv_2: ",
    "sweep_losses": "neighbour_age_mean_s",
}


def test_every_example_is_described_and_tried():
    described = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    assert {path.stem for path in PROGRAMS} == set(SAYS)
    assert all(f"| `{path.name}` |" in described for path in PROGRAMS)


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_an_example_runs(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SHOAL_PLUGINS", "")
    folder = auv_flocking.separation
    monkeypatch.setattr(folder, "__path__", [*folder.__path__])  # own_law adds to it
    monkeypatch.setattr("sys.argv", [str(path)])
    spec = importlib.util.spec_from_file_location(f"example_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.main()
    assert SAYS[path.stem] in capsys.readouterr().out
    if path.stem == "plot_a_run":
        assert (tmp_path / "depths.png").stat().st_size > 5000
