"""Every package.xml says who made the package, and names every package that its files import at run time."""

import ast
import re
import sys
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from source_tree import ORDER
from source_tree import PACKAGES as PYTHON_PACKAGES

ROOT = Path(__file__).parents[1]

# Keys of the official rosdep lists, by the module that is imported.
OFFICIAL_KEYS = {
    "filterpy": "python3-filterpy-pip",
    "matplotlib": "python3-matplotlib",
    "numba": "python3-numba",
    "numpy": "python3-numpy",
    "pandas": "python3-pandas",
    "psutil": "python3-psutil",
    "rosbags": "python3-rosbags-pip",
    "scipy": "python3-scipy",
    "tqdm": "python3-tqdm",
    "xarray": "python3-xarray",
    "yaml": "python3-yaml",
}
# Those of requirements/rosdep.yaml.
OWN_KEYS = {
    "distributed": "python3-distributed-pip",
    "mcap": "python3-mcap-pip",
    "pyarrow": "python3-pyarrow-pip",
    "setproctitle": "python3-setproctitle",
    "skfuzzy": "python3-scikit-fuzzy-pip",
    "zstandard": "python3-zstandard",
}
KEYS = OFFICIAL_KEYS | OWN_KEYS
# Put in by hand, for one plugin: ./scripts/setup --with bellhop
OPTIONAL = {"pelagic"}


@cache
def manifest(package):
    return ElementTree.parse(ROOT / "src" / package / "package.xml").getroot()


def depended(package, *kinds):
    return {each.text for kind in kinds for each in manifest(package).findall(kind)}


def imported(package):
    """Return the imports of a package's files, including launch files and imports in functions."""
    folder = ROOT / "src" / package
    found = set()
    for path in [*(folder / package).rglob("*.py"), *folder.glob("launch/*.py")]:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                found.add(node.module.split(".")[0])
    return found - sys.stdlib_module_names - OPTIONAL - {package}


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_every_import_at_run_time_is_a_dependency(package):
    needed = {KEYS.get(module, module) for module in imported(package)}
    assert needed - depended(package, "depend", "exec_depend") == set()


def test_every_package_whose_messages_ours_hold_is_a_dependency():
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "src" / "auv_msgs" / "msg").glob("*.msg")]
    held = {package for text in texts for package in re.findall(r"^(\w+)/\w+", text, re.MULTILINE)}
    assert held == depended("auv_msgs", "depend")


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_no_library_is_a_dependency_without_an_import(package):
    declared = {key for key in depended(package, "depend", "exec_depend") if key.startswith("python3-")}
    assert declared <= {KEYS.get(module, module) for module in imported(package)}


def test_keys_that_the_official_lists_lack_are_in_our_own():
    ours = yaml.safe_load((ROOT / "requirements" / "rosdep.yaml").read_text(encoding="utf-8"))
    assert set(ours) == set(OWN_KEYS.values())
    pinned = (ROOT / "requirements" / "wheels.lock").read_text(encoding="utf-8")
    for key, rules in ours.items():
        assert set(rules) == {"debian", "ubuntu"}
        if isinstance(rules["ubuntu"], dict):
            (name,) = rules["ubuntu"]["pip"]["packages"]
            assert key == f"python3-{name}-pip"
            assert re.search(f"^{name}==", pinned, re.MULTILINE)


@pytest.mark.parametrize("package", ORDER)
def test_it_names_author_maintainer_and_license_and_no_page_that_does_not_exist(package):
    root = manifest(package)
    for kind in ("author", "maintainer"):
        assert root.find(kind).text == "The Shoal authors"
        assert "@" in root.find(kind).get("email")
    assert root.find("license").text == "Apache-2.0"
    assert not [url.text for url in root.findall("url") if "example.org" in url.text]
