"""One version in every file that states it; the changelogs of the packages, as catkin_pkg reads them."""

import importlib.util
import re
import shutil
from pathlib import Path

import pytest
from catkin_pkg.changelog import get_changelog_from_path

ROOT = Path(__file__).parents[1]
MARKDOWN = """# Changelog

## [Unreleased]

### Added
- A thing with `code_of_it` and a [page](docs/page.md).
  Its second line has *stars* and under_scores_.
- Another.

## [0.2.0] - 2026-03-01

### Changed
- Less.

## [0.1.0] - 2026-01-31

### Added
- All, see [the site](https://example.org/x).
"""


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("release", ROOT / "scripts" / "release.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def read(script, tmp_path, markdown):
    path = tmp_path / "CHANGELOG.rst"
    path.write_text(script.changelog_rst("auv_core", markdown), encoding="utf-8")
    return get_changelog_from_path(str(path), "auv_core")


def test_catkin_pkg_finds_every_version_with_its_date_and_lines(script, tmp_path):
    changelog = read(script, tmp_path, MARKDOWN)
    found = {version: date.date().isoformat() for version, date, _ in changelog.foreach_version()}
    assert found == {"0.2.0": "2026-03-01", "0.1.0": "2026-01-31"}
    assert "Less." in str(changelog.get_content_of_version("0.2.0")[0])
    assert "the site (https://example.org/x)" in str(changelog.get_content_of_version("0.1.0")[0])


def test_what_is_not_released_is_forthcoming(script):
    rst = script.changelog_rst("auv_core", MARKDOWN)
    assert rst.startswith("^^^^^^")
    assert (
        "Forthcoming\n-----------\n\n* Added\n\n  * A thing with ``code_of_it`` and a page.\n    Its second"
        in rst
    )


def test_the_changelog_of_this_tree_can_be_released(script, tmp_path):
    markdown = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    changelog = read(script, tmp_path, markdown.replace("## [Unreleased]", "## [9.9.9] - 2026-12-31", 1))
    assert next(iter(changelog.foreach_version()))[0] == "9.9.9"
    entries = sum(line.startswith("- ") for line in markdown.splitlines())
    assert script.changelog_rst("auv_core", markdown).count("\n  * ") == entries


def test_a_heading_that_is_no_version_is_refused(script):
    with pytest.raises(script.ChangelogError, match=r"'## 0\.3' is not allowed; allowed: ## \[Unreleased\]"):
        script.changelog_rst("auv_core", "## 0.3\n")


@pytest.fixture
def tree(script, tmp_path):
    """Return a copy of the files that a release writes."""
    for pattern in ("CHANGELOG.md", *script.STATED):
        for path in ROOT.glob(pattern):
            copy = tmp_path / path.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, copy)
    return tmp_path


def test_every_file_states_the_same_version(script):
    stated = script.stated_versions(ROOT)
    packages = {path.parent.name for path in ROOT.glob("src/*/package.xml")}
    assert {"CITATION.cff", *(f"src/{name}/package.xml" for name in packages)} <= set(stated)
    assert {re.sub(r"\.dev\d+$", "", version) for version in stated.values()} == {stated["CITATION.cff"]}


def test_a_release_writes_version_and_date_everywhere(script, tree):
    assert script.main(["9.9.9", "2026-12-31"], tree) == 0
    assert set(script.stated_versions(tree).values()) == {"9.9.9"}
    assert "## [Unreleased]\n\n## [9.9.9] - 2026-12-31\n" in (tree / "CHANGELOG.md").read_text(
        encoding="utf-8"
    )
    changelog = get_changelog_from_path(str(tree / "src" / "auv_core" / "CHANGELOG.rst"), "auv_core")
    assert [version for version, _, _ in changelog.foreach_version()][:1] == ["9.9.9"]


@pytest.mark.parametrize("arguments", [["0.2"], ["0.2.0"], ["0.2.0", "March"], ["v0.2.0", "2026-03-01"]])
def test_a_version_or_date_of_another_form_is_refused(script, tree, capsys, arguments):
    before = script.stated_versions(tree)
    with pytest.raises(SystemExit, match="2"):
        script.main(arguments, tree)
    assert "allowed: a version and a date, like 0.2.0 2026-03-01" in capsys.readouterr().err
    assert script.stated_versions(tree) == before
