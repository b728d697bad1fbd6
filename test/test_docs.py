"""Claims about the documentation: it builds strictly, needs no network, and says all that the code says."""

import ast
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from from_code.commands import commands_of, python_path
from from_code.hook import on_page_markdown
from from_code.keys import Key, keys_of, plugin_folders, scenario_keys, unit_of
from from_code.messages import read_message
from from_code.notebook import notebook_page
from from_code.plugins import OWN, contracts_of
from from_code.topics import when

from auv_bag.topics import COMMON_TOPICS, VEHICLE_TOPICS
from auv_core.params import dump
from auv_core.plugins import list_plugins
from auv_experiment.scenario.loading import list_scenarios, load_scenario
from auv_experiment.scenario.schema import Scenario

ROOT = Path(__file__).parents[1]
TOPICS = (*VEHICLE_TOPICS, *COMMON_TOPICS)
MESSAGES = sorted((ROOT / "src/auv_msgs/msg").glob("*.msg"))
MISREAD = re.compile(r"<p>(?:(?!</p>).)*?\n(?:\* |- |\d+\. |\|)", re.DOTALL)
"""A list or a table without an empty line before it."""
LOADED = re.compile(r"<(?:script|link|img|iframe)\b[^>]*?(?:src|href)=[\"']?(https?:)?//[^\"'> ]+")


def built(place):
    """Build the site as ./scripts/docs does; return what the command said."""
    paths = os.pathsep.join([str(ROOT / "docs"), python_path(ROOT)])
    done = subprocess.run(
        [sys.executable, "-P", "-m", "mkdocs", "build", "--quiet", "--site-dir", str(place)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": paths, "NO_MKDOCS_2_WARNING": "true"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_the_site_is_built_strictly_and_needs_no_network(tmp_path):
    assert built(tmp_path) == ""
    pages = {path: path.read_text(encoding="utf-8") for path in tmp_path.rglob("*.html")}
    assert {path.relative_to(tmp_path).as_posix() for path in pages} >= {
        "index.html",
        "reference/scenario_keys.html",
        "reference/python.html",
    }
    assert {path.name: LOADED.findall(text) for path, text in pages.items() if LOADED.search(text)} == {}
    assert not [path.name for path, text in pages.items() if "from code:" in text]
    assert {path.name: MISREAD.findall(text) for path, text in pages.items() if MISREAD.search(text)} == {}
    styles = [path.read_text(encoding="utf-8") for path in tmp_path.rglob("*.css")]
    assert not [text for text in styles if re.search(r"url\([\"']?(https?:)?//", text)]


def test_a_page_cannot_ask_for_what_is_not_made():
    assert "`/tf`" in on_page_markdown("<!-- from code: topics -->")
    with pytest.raises(KeyError):
        on_page_markdown("<!-- from code: nothing -->")


def paths_of(plain, prefix=""):
    """Yield the dotted paths of plain data as in the reference, without those of plugins."""
    for name, value in plain.items():
        path = prefix + name
        if isinstance(value, list) and value and isinstance(value[0], dict):
            yield path + "[]"
            for item in value:
                yield from paths_of(item, path + "[].")
        else:
            yield path
            if isinstance(value, dict) and "kind" not in value:
                yield from paths_of(value, path + ".")


def test_the_reference_has_every_key_of_every_scenario():
    listed = {key.path.replace("[]", "") for key in keys_of(Scenario)}
    for name, _ in list_scenarios():
        used = {path.replace("[]", "") for path in paths_of(dump(load_scenario(name)))}
        assert used <= listed, name


def test_the_reference_has_every_plugin_of_every_folder():
    page = scenario_keys()
    assert len(plugin_folders()) >= 12
    for folder in plugin_folders():
        for kind in list_plugins(folder):
            assert f"### `{kind}` {{ #{folder.rpartition('.')[2]}-{kind} }}" in page


def test_every_plugin_folder_states_its_contracts():
    assert [folder for folder in (*plugin_folders(), *OWN) if not contracts_of(folder)] == []


@pytest.mark.parametrize(
    ("name", "doc", "unit"),
    [
        ("hold_s", "longest time (s)", "s"),
        ("current_ned_mps", "velocity of the water (m/s; NED)", "m/s"),
        ("inertia", "mass (kg) and moment of inertia (kg m^2), added too", "kg, kg m^2"),
        ("gain", "weights k_l (of the layers)", "–"),
        ("gate_prob", "probability that it is one", "–"),
    ],
)
def test_a_unit_is_what_the_meaning_states_or_the_name_ends_with(name, doc, unit):
    from dataclasses import make_dataclass

    from auv_core.params import param

    (field,) = keys_of(make_dataclass("Params", [(name, float, param(doc))]))
    assert unit_of(Key(*field)) == unit


@pytest.mark.parametrize("path", MESSAGES, ids=lambda path: path.stem)
def test_every_field_of_a_message_has_a_meaning_or_a_name_that_says_it(path):
    message = read_message(path)
    assert message.words
    assert message.fields
    assert all(words for _, _, words in message.constants)
    without = {name for name, kind, words in message.fields if not words and not kind.endswith("[]")}
    assert without == set()


def test_a_line_that_is_no_field_is_not_passed_over(tmp_path):
    path = tmp_path / "Odd.msg"
    path.write_text("# Odd.\n\nint64 tick  # (-)\nint64 Tick\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"Odd\.msg: 'int64 Tick' is neither a field nor a constant"):
        read_message(path)


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)
def test_a_topic_says_from_whom_when_what_and_what_silence_means(topic):
    assert topic.publisher
    assert topic.readers
    assert when(topic)
    assert topic.fields.endswith(".")
    assert topic.silence.endswith(".")


def test_a_topic_of_ours_has_a_message_of_the_reference():
    ours = {topic.type_name.split("/")[2] for topic in TOPICS if topic.type_name.startswith("auv_msgs/")}
    assert ours <= {path.stem for path in MESSAGES}


def topic_calls(path):
    """Yield the calls of `Topics.add` and of `Topic` in a source file."""
    for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(call, ast.Call) and (
            getattr(call.func, "attr", "") == "add" or getattr(call.func, "id", "") == "Topic"
        ):
            yield call


def topics_in_nodes():
    """Yield package, type, name and whether it is latched of each topic that a node names in its source."""
    for path in sorted(ROOT.glob("src/auv_*/auv_*/nodes/*.py")):
        for call in topic_calls(path):
            kinds = [each.id for each in call.args if isinstance(each, ast.Name) and each.id[0].isupper()]
            words = [each for each in call.args if isinstance(each, ast.Constant | ast.JoinedStr)]
            if kinds and words:
                *_, last = getattr(words[0], "values", words)
                name = last.value if isinstance(words[0], ast.Constant) else last.value.lstrip("/")
                latched = any(getattr(each.value, "id", "").startswith("LATCHED") for each in call.keywords)
                yield path.parts[-3], kinds[0].removesuffix("Msg"), name, latched


def test_topics_are_declared_as_nodes_publish_them():
    nodes = {"auv_flocking": {"agent_node"}, "auv_sim": {"vehicle_node", "acoustic_relay_node", "clock_node"}}
    declared = {topic.name: topic for topic in TOPICS}
    published = list(topics_in_nodes())
    assert len({name for _, _, name, _ in published}) >= 17
    for package, kind, name, latched in published:
        topic = declared[name]
        assert (topic.type_name.split("/")[2], topic.latched) == (kind, latched), name
        assert nodes[package] & set(re.findall(r"\w+_node", topic.publisher)), name


def test_the_commands_are_those_of_the_folder():
    assert {"docs", "run", "setup", "test"} <= {path.name for path in commands_of(ROOT)}


def test_the_notebook_is_kept_without_what_its_cells_gave():
    notebook = json.loads((ROOT / "docs/tutorials/reading_results.ipynb").read_text(encoding="utf-8"))
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(code) > 5
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)


def test_a_cell_is_shown_with_what_it_gave(tmp_path):
    cells = [
        nbformat.v4.new_markdown_cell("# A page"),
        nbformat.v4.new_code_cell("print(6 * 7)"),
        nbformat.v4.new_code_cell("[1, 2]"),
    ]
    path = tmp_path / "page.ipynb"
    nbformat.write(nbformat.v4.new_notebook(cells=cells), path)
    page = notebook_page(path)
    shown = ["# A page", "```python\nprint(6 * 7)\n```", "```text\n42\n```", "```python\n[1, 2]\n```"]
    assert page.markdown == "\n\n".join([*shown, "```text\n[1, 2]\n```\n"])
    assert page.images == {}


def test_files_that_pages_name_exist():
    made_up = re.compile(r"/home/|.*\bgentle\.py|recording\.npz")
    kept = [
        path
        for folder in ("benchmarks", "docs", "examples", "requirements", "scripts", "src", "test")
        for path in (ROOT / folder).rglob("*.*")
    ]
    known = {path.relative_to(ROOT).parts for path in [*kept, *ROOT.glob("*.*")]}
    tails = {"/".join(parts[first:]) for parts in known for first in range(len(parts))}
    pages = [*ROOT.glob("[CRS]*.md"), *ROOT.glob("src/*/README.md"), *(ROOT / "docs").rglob("*.md")]
    named = {
        (page.name, file)
        for page in pages
        if page.name != "CHANGELOG.md"
        for file in re.findall(
            r"`([\w./-]+\.(?:bash|in|lock|md|msg|npz|py|rviz|toml|xml))`", page.read_text(encoding="utf-8")
        )
        if not made_up.match(file)
    }
    assert len(named) > 80
    assert {(page, file) for page, file in named if file.removeprefix("./") not in tails} == set()
