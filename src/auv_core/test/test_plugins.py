"""Claims about plugin folders: a kind is a file, and nothing else."""

import importlib
import sys

import pytest

from auv_core.plugins import PluginError, find_plugin, list_plugins


def test_kinds_are_the_files_of_the_folder_sorted():
    assert list_plugins("auv_core.models") == [
        "four_dof",
        "kinematic",
        "six_dof",
        "torpedo",
        "torpedo_coefficients",
    ]


def test_found_module_is_the_file_of_that_name():
    assert find_plugin("auv_core.models", "six_dof") is importlib.import_module("auv_core.models.six_dof")


@pytest.mark.parametrize(
    "kind", ["", "Six_dof", "six_dof\n", "no_such", ".six_dof", "six_dof.Model", "__init__", 3, None, []]
)
def test_other_kinds_are_refused_and_the_known_ones_named(kind):
    with pytest.raises(
        PluginError,
        match=r"is not allowed; allowed: four_dof, kinematic, six_dof, torpedo, torpedo_coefficients",
    ):
        find_plugin("auv_core.models", kind)


def test_a_new_file_is_a_new_kind(tmp_path, monkeypatch):
    folder = tmp_path / "shoal_test_plugins"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "second.py").write_text("ANSWER = 2\n")
    (folder / "_private.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    assert list_plugins("shoal_test_plugins") == ["second"]
    assert find_plugin("shoal_test_plugins", "second").ANSWER == 2
    for name in [name for name in sys.modules if name.startswith("shoal_test_plugins")]:
        monkeypatch.delitem(sys.modules, name)
