"""Claims about the page of the reproduction and the command that makes it, on a chapter of tiny runs."""

import base64
import json
import re
import signal
import types
from functools import cache
from html.parser import HTMLParser
from typing import Any

import pytest

from auv_core.cli.failures import FAILED
from auv_thesis import cli
from auv_thesis.items import (
    Chapter,
    ChapterError,
    Claim,
    Figure,
    Row,
    RunSpec,
    Table,
    Verdict,
    chapters_of,
    choose,
)

FOUR = RunSpec("ch5_four_leaders", ("dt_s=0.1",), 1.0)
ONE = RunSpec("ch5_one_leader", ("dt_s=0.1",), 1.0)
WRONG = RunSpec("ch5_one_leader", ("nonsense=1",))


def draw_track(canvas, runs):
    panels = canvas.subplots(1, len(runs), squeeze=False)[0]
    for axes, run in zip(panels, runs, strict=True):
        axes.plot(run.recording.t_s, run.recording.position_ned_m[:, 0, 0])


def raise_in_two_lines(*_):
    raise ValueError("nothing\nto draw")


def distances(runs):
    return [
        Row(
            str(run.spec),
            "1.6",
            f"{run.metrics['pair_distance_min_m']:.3f}",
            "agrees in part",
            "<note> & more",
        )
        for run in runs
    ]


def judge_distance(runs):
    return Verdict("does not hold", f"{runs[0].metrics['pair_distance_min_m']:.1f} m < 100 m")


FIGURES = (
    Figure("5.5", "track of <one> & all", (FOUR,), draw_track, "the thesis's & ours"),
    Figure("5.6", "two tracks", (FOUR, ONE), draw_track, "caption"),
)
TABLES = (Table("5.A", "distances", (FOUR, ONE), distances, "asked <for>"),)
CLAIMS = (
    Claim("5.8", "they fly", (ONE,), lambda runs: Verdict("holds", "they do")),
    Claim("5.8", "they are far apart", (FOUR,), judge_distance),
)


def no_rows(_runs) -> Any:
    return ["none"]


def no_verdict(_runs) -> Any:
    return True


GOOD = Chapter("ch5", "Chapter 5: <flock>", FIGURES, TABLES, CLAIMS)
BAD = Chapter(
    "ch6",
    "Chapter 6",
    (
        Figure("6.3", "needs a run that fails", (FOUR, WRONG), draw_track, "caption"),
        Figure("6.4", "raises", (FOUR,), raise_in_two_lines, "caption"),
    ),
    (Table("6.1", "no rows", (FOUR,), no_rows),),
    (Claim("6.2", "no verdict", (FOUR,), no_verdict),),
)


class Page(HTMLParser):
    """What of a page could fetch something, and its anchors, links and images."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.images, self.sources = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        known = dict(attrs)
        self.ids += [known["id"]] if "id" in known else []
        if tag == "a":
            self.links.append(known["href"])
        elif "href" in known:
            self.sources.append(known["href"])
        if tag == "img":
            self.images.append(known)
        assert tag not in {"script", "link", "iframe", "object", "embed", "base", "form"}
        self.sources += [known[key] for key in ("src", "srcset", "poster", "data") if key in known]


@pytest.fixture(scope="module", autouse=True)
def _keep_signal_handlers():
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page") / "out"
    status = cli.main(["--out", str(folder), "--workers", "2", "--format", "pdf"], [GOOD])
    return status, folder


def test_all_of_it_is_made(made):
    status, folder = made
    assert status == 0
    assert not (folder / "failures.txt").exists()
    assert sorted(path.name for path in (folder / "figures").iterdir()) == [
        "figure_5-5.pdf",
        "figure_5-5.png",
        "figure_5-6.pdf",
        "figure_5-6.png",
    ]


def test_a_figure_for_a_paper_has_one_column_or_with_panels_two(made):
    for number, width_pt in (("5-5", b"252 "), ("5-6", b"515.52 ")):
        data = (made[1] / f"figures/figure_{number}.pdf").read_bytes()
        assert b"/MediaBox [ 0 0 " + width_pt in data


def test_the_page_needs_nothing_else(made):
    text = (made[1] / "index.html").read_text(encoding="utf-8")
    page = Page(text)
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    assert not re.search(r"https?:|//[a-z]|url\(|@import", re.sub(r"base64,[^\"]*", "", text))
    assert "default-src 'none'" in text


def test_every_figure_is_in_it_with_a_text_for_who_cannot_see_it(made):
    folder = made[1]
    images = Page((folder / "index.html").read_text(encoding="utf-8")).images
    assert [image["alt"].startswith(f"Figure {f.number}. ") for image, f in zip(images, FIGURES, strict=True)]
    for image, figure in zip(images, FIGURES, strict=True):
        data = base64.b64decode(image["src"].partition(",")[2])
        assert data == (folder / f"figures/figure_{figure.number.replace('.', '-')}.png").read_bytes()
        assert data.startswith(b"\x89PNG")


def test_links_lead_to_places_that_are_there_once(made):
    page = Page((made[1] / "index.html").read_text(encoding="utf-8"))
    assert len(page.ids) == len(set(page.ids))
    assert {link.removeprefix("#") for link in page.links} <= set(page.ids)


def test_what_chapters_say_is_escaped(made):
    text = (made[1] / "index.html").read_text(encoding="utf-8")
    assert "<one>" not in text
    assert "<note>" not in text
    assert "&lt;one&gt; &amp; all" in text


def test_a_table_says_what_its_numbers_stand_beside(made):
    assert "<th scope='col'>asked &lt;for&gt;</th>" in (made[1] / "index.html").read_text(encoding="utf-8")


def test_the_summary_says_the_same_in_json(made):
    summary = json.loads((made[1] / "summary.json").read_text(encoding="utf-8"))
    assert summary["counts"]["claims"] == {"holds": 1, "holds in part": 0, "does not hold": 1}
    assert summary["counts"]["rows"]["agrees in part"] == 2
    chapter = summary["chapters"]["ch5"]
    assert [claim["holds"] for claim in chapter["claims"]] == ["holds", "does not hold"]
    assert float(chapter["tables"][0]["rows"][0]["ours"]) > 1.0
    assert chapter["figures"][0]["file"] == "figures/figure_5-5.png"
    assert {run["run"] for run in summary["runs"]} == {str(FOUR), str(ONE)}
    assert all(run["wall_s"] > 0.0 and run["cpu_s"] > 0.0 for run in summary["runs"])


def test_claims_and_tables_are_there_as_markdown(made):
    (file,) = (made[1] / "chapters").iterdir()
    text = file.read_text(encoding="utf-8")
    assert file.name == "ch5.md"
    assert [text.count(f"**{verdict}.** ") for verdict in ("holds", "does not hold")] == [1, 1]
    assert text.index("**holds.**") < text.index("| quantity | asked <for> | ours | verdict | note |")
    rows = json.loads((made[1] / "summary.json").read_text(encoding="utf-8"))["chapters"]["ch5"]["tables"][0][
        "rows"
    ]
    assert sum(f"| {row['ours']} | {row['verdict']} |" in text for row in rows) == len(rows) > 0


def test_what_fails_is_told_and_touches_nothing_else(made, tmp_path, capfd):
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures/figure_9-9.png").touch()
    (tmp_path / "chapters").mkdir()
    (tmp_path / "chapters/ch9.md").touch()
    status = cli.main(["--out", str(tmp_path), "--workers", "2"], [GOOD, BAD])
    assert status == 1
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert summary["counts"]["failures"]["failed"] == 4
    assert summary["counts"]["figures"]["drawn"] == 2
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    for words in ("unknown key &#x27;nonsense&#x27;", "ValueError: nothing to draw", "must return rows"):
        assert words in text
    assert len(list((tmp_path / "figures").iterdir())) == 2, "those of an earlier call are gone"
    assert {path.name for path in (tmp_path / "chapters").iterdir()} == {"ch5.md", "ch6.md"}
    failed = (tmp_path / "chapters/ch6.md").read_text(encoding="utf-8")
    assert failed.count("Could not be made: ") == 2
    assert "in raise_in_two_lines" in (tmp_path / "failures.txt").read_text(encoding="utf-8")
    *_, last = capfd.readouterr().err.splitlines()
    assert last.startswith("error: 5 items could not be made; see ")


def test_items_of_one_file_without_runs_share_a_study_and_fail_alone(tmp_path):
    studied = tmp_path / "studied"

    @cache
    def study():
        with studied.open("a") as stream:
            stream.write("once ")
        return 2.0

    def draw_study(canvas, _runs):
        canvas.subplots().plot([study()])

    def fail(_runs):
        raise ValueError(f"{study()} is no verdict")

    chapter = Chapter(
        "study",
        "Study",
        (Figure("S.1", "line", (), draw_study, "caption"),),
        (Table("S.1", "rows", (), lambda _runs: [Row("two", "2", str(study()), "agrees")]),),
        (Claim("S.1", "text", (), fail),),
    )
    assert cli.main(["--out", str(tmp_path / "page"), "--workers", "3"], [chapter]) == FAILED
    assert studied.read_text() == "once "
    failures = (tmp_path / "page" / "failures.txt").read_text()
    assert failures.count("== ") == 1
    assert "== claim S.1" in failures
    assert "ValueError: 2.0 is no verdict" in failures


def test_list_flies_nothing(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["--list"], [GOOD, BAD]) == 0
    out = capsys.readouterr().out
    assert "figure 5.6      two tracks" in out
    assert "claim  5.8      they are far apart" in out
    assert "table  6.1 " in out
    assert list(tmp_path.iterdir()) == []


def test_only_chooses_chapters(capsys):
    assert cli.main(["--list", "--only", "ch6,ch5"], [GOOD, BAD]) == 0
    assert cli.main(["--list", "--only", "ch6"], [GOOD, BAD]) == 0
    out = capsys.readouterr().out
    assert out.count("ch5  Chapter 5") == 1
    assert out.count("ch6  Chapter 6") == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--only", "ch9"], "error: --only: 'ch9' is not allowed; allowed: ch5, ch6"),
        (["--only", "ch5,"], "error: --only: '' is not allowed; allowed: ch5, ch6"),
        (["--workers", "0"], "'0' is not allowed; allowed: a whole number from 1 to 256"),
        (["--workers", "two"], "'two' is not allowed; allowed: a whole number from 1 to 256"),
        (["--out", "/proc/nowhere"], "error: --out '/proc/nowhere': cannot be written"),
        (["ch5"], "error: unrecognized arguments: ch5"),
        (["--list", "--docs"], "not allowed with argument"),
    ],
)
def test_bad_arguments_are_refused_in_one_line(arguments, words, capsys):
    status: Any
    try:
        status = cli.main(arguments, [GOOD, BAD])
    except SystemExit as end:
        status = end.code
    (line,) = capsys.readouterr().err.splitlines()
    assert status == 2
    assert words in line


def module(**words):
    return types.SimpleNamespace(**words)


def test_files_of_one_chapter_come_together_and_in_reading_order():
    found = chapters_of(
        {
            "path_laws": module(TABLES=(TABLES[0],)),
            "ch2_obstacles": module(FIGURES=(FIGURES[1],), CLAIMS=(CLAIMS[0],)),
            "ch2": module(FIGURES=FIGURES, TITLE="Second"),
            "another_law": module(CLAIMS=(CLAIMS[1],)),
            "runner": module(fly_all=None),
        }
    )
    assert [chapter.key for chapter in found] == ["ch2", "path_laws", "another_law"]
    assert found[0].title == "Second"
    assert found[0].figures == FIGURES
    assert found[0].claims == (CLAIMS[0],)
    assert found[0].runs == (FOUR, ONE)
    assert choose(found, ["another_law"]) == (found[2],)


def test_one_number_means_one_figure():
    other = Figure("5.5", "another", (ONE,), draw_track, "")
    with pytest.raises(ChapterError, match=r"figure 5\.5 is defined twice"):
        chapters_of({"ch5": module(FIGURES=FIGURES), "ch6": module(FIGURES=(other,))})


def test_what_is_no_figure_is_refused():
    with pytest.raises(ChapterError, match=r"ch5: FIGURES holds 'x'; allowed: Figure"):
        chapters_of({"ch5": module(__name__="ch5", FIGURES="x")})


def test_words_that_are_no_verdict_are_refused():
    with pytest.raises(ValueError, match="verdict: 'good' is not allowed; allowed: agrees, "):
        Row("q", "1", "1", "good")
    with pytest.raises(ValueError, match="holds: 'yes' is not allowed; allowed: holds, "):
        Verdict("yes", "")


def test_a_run_is_named_as_it_is_given_to_the_command():
    assert str(FOUR) == "ch5_four_leaders --set dt_s=0.1 --duration 1"
    assert str(RunSpec("a", ("b.c=[0, 1]",))) == "a --set 'b.c=[0, 1]'"
