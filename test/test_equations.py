"""The list of equations, the chapters of the reproduction and the generated documents match the source."""

from pathlib import Path

import pytest

from auv_thesis.items import ChapterError, chapters
from auv_thesis.page.documents import documents, write_documents
from auv_thesis.page.equations import EQUATIONS_FILE, load_equations, numbers_in, problems

ROOT = Path(__file__).parents[1]
LISTED = load_equations(ROOT)

SMALL_LIST = """\
chapters: {2: 3}
implemented:
  - equations: "2.1"
    what: a function
    functions: ["auv_core.geometry:distance"]
    tests: ["test/test_here.py::test_it"]
left_out:
  - equations: "2.2-2.3"
    what: steps
    why: algebra
"""


def test_the_list_and_the_source_fit():
    assert problems(LISTED, ROOT) == []


def test_the_list_has_every_equation_of_the_five_chapters():
    assert LISTED.counts == {2: 48, 3: 40, 4: 14, 5: 44, 6: 47}


@pytest.mark.parametrize("page", ["docs/reference/equations.md", "docs/reference/figures.md"])
def test_the_page_is_what_the_command_would_write(page):
    written = (ROOT / page).read_text(encoding="utf-8")
    assert written == documents(chapters(), LISTED)[page], "./scripts/reproduce --docs writes it again"


def small(tmp_path, *changes):
    text = SMALL_LIST
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    for path, content in (
        (EQUATIONS_FILE, text),
        ("test/test_here.py", "def test_it():\n    assert True\n"),
        ("src/auv_core/auv_core/law.py", '"""A law, thesis Eq. (2.2), beside Fossen (2021) Eq. (3.60)."""\n'),
    ):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(content, encoding="utf-8")
    return load_equations(tmp_path)


def test_a_list_that_fits_has_no_problems(tmp_path):
    assert problems(small(tmp_path), tmp_path) == []


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (("2.2-2.3", "2.2"), "(2.3) is not listed"),
        (("2.2-2.3", "2.1-2.3"), "(2.1) is listed 2 times"),
        (("2.2-2.3", "2.2-2.4"), "(2.4) is listed, but the thesis has no such equation"),
        (("geometry:distance", "geometry:nowhere"), "auv_core.geometry:nowhere cannot be imported"),
        (("auv_core.geometry:", "auv_core.nowhere:"), "auv_core.nowhere:distance cannot be imported"),
        (("::test_it", "::test_that"), "there is no test test/test_here.py::test_that"),
        (("test_here", "test_there"), "there is no test test/test_there.py::test_it"),
        (('["test/test_here.py::test_it"]', "[]"), "an implemented equation has a function and a test"),
    ],
)
def test_what_does_not_fit_is_told(tmp_path, change, line):
    found = problems(small(tmp_path, change), tmp_path)
    assert any(line in problem for problem in found), found


def test_an_equation_that_another_module_cites_is_told(tmp_path):
    listed = small(tmp_path, ('"2.1"', '"2.2"'), ('"2.2-2.3"', '"2.1, 2.3"'))
    assert problems(listed, tmp_path) == [
        "(2.2) is cited by auv_core.law, but listed with auv_core.geometry only"
    ]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('"2.1"', "2.10"), "equations are text, in quotes"),
        (('"2.1"', '"two"'), "'two' is not allowed; allowed: numbers and ranges like 2.6-2.7"),
        (('"2.2-2.3"', '"2.3-2.2"'), "is not a range within a chapter"),
        (("    why: algebra\n", ""), r"missing keys \['why'\]"),
        (("what: steps", "that: steps"), r"unknown keys \['that'\]"),
        (("left_out:", "left:"), "'left_out'"),
    ],
)
def test_a_list_that_cannot_be_understood_is_refused_in_one_line(tmp_path, change, words):
    with pytest.raises(ChapterError, match=words) as error:
        small(tmp_path, change)
    assert "\n" not in str(error.value)


def test_ranges_are_read_one_by_one():
    assert numbers_in("2.6-2.8, 3.10") == ((2, 6), (2, 7), (2, 8), (3, 10))


def test_pages_are_written_where_they_are_looked_for(tmp_path):
    small(tmp_path)
    written = write_documents([], tmp_path)
    assert [path.relative_to(tmp_path).as_posix() for path in written] == [
        "docs/reference/equations.md",
        "docs/reference/figures.md",
    ]
    assert "(2.2)-(2.3)" in written[0].read_text(encoding="utf-8")
