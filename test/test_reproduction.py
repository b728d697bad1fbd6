"""The chapters of the reproduction cover all items of the thesis, and use runs that exist."""

import re

import pytest

from auv_core.cli.failures import DONE
from auv_thesis import cli
from auv_thesis.items import RunSpec, chapters
from auv_thesis.runs.store import resolve_run

CHAPTERS = {chapter.key: chapter for chapter in chapters()}
FIGURES = {
    "ch2": [f"2.{n}" for n in range(6, 19)],
    "ch3": [f"3.{n}" for n in range(4, 15)],
    "ch4": ["4.5", "4.6"],
    "ch5": [f"5.{n}" for n in range(5, 13)],
    "ch6": [f"6.{n}" for n in range(3, 10)],
}
TABLES = {"ch2": ["2.2"], "ch3": ["3.1"], "ch4": ["4.1"], "ch6": ["6.1"]}
SPECS = sorted({spec for chapter in CHAPTERS.values() for spec in chapter.runs}, key=str)


def test_every_chapter_of_the_thesis_with_simulations_is_there():
    assert list(CHAPTERS)[:6] == ["ch2", "ch3", "formation", "ch4", "ch5", "ch6"]
    assert {"path_laws", "separation_laws"} <= set(CHAPTERS)


@pytest.mark.parametrize("key", FIGURES)
def test_every_figure_of_the_thesis_is_redrawn(key):
    assert set(FIGURES[key]) <= {figure.number for figure in CHAPTERS[key].figures}


@pytest.mark.parametrize("key", TABLES)
def test_every_table_of_the_thesis_is_filled(key):
    assert set(TABLES[key]) <= {table.number for table in CHAPTERS[key].tables}


@pytest.mark.parametrize("key", FIGURES)
def test_every_chapter_of_the_thesis_has_claims(key):
    assert len(CHAPTERS[key].claims) >= 2


def test_numbers_are_the_thesiss_or_have_a_letter():
    for key, chapter in CHAPTERS.items():
        for kind, items in ((FIGURES, chapter.figures), (TABLES, chapter.tables)):
            for item in items:
                of_thesis = item.number in kind.get(key, [])
                assert of_thesis or re.search(r"\.[A-Z]$|^[AET]\.\d+$", item.number), f"{key}: {item.number}"


def test_every_item_says_what_it_is():
    for chapter in CHAPTERS.values():
        assert all(figure.title and len(figure.caption) > 40 for figure in chapter.figures)
        assert all(table.title for table in chapter.tables)
        assert all(claim.number and claim.text for claim in chapter.claims)


def one_of_each_case():
    """Return the runs without those that differ from an earlier one in their seed only."""
    cases: dict[tuple[object, ...], RunSpec] = {}
    for spec in SPECS:
        seedless = tuple(word for word in spec.overrides if not word.startswith("seed="))
        cases.setdefault((spec.scenario, seedless, spec.duration_s), spec)
    return cases.values()


@pytest.mark.parametrize("scenario", sorted({spec.scenario for spec in SPECS}))
def test_runs_can_be_resolved(scenario):
    for spec in one_of_each_case():
        if spec.scenario == scenario:
            assert resolve_run(spec).scenario.name == scenario


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_all_of_it_is_made(tmp_path):
    assert cli.main(["--out", str(tmp_path)]) == DONE
