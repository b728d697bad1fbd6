"""The prose of this project is plain English: this test finds turns that make readers stumble."""

import io
import re
import subprocess
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROSE = {".bash", ".cff", ".in", ".md", ".msg", ".py", ".toml", ".yaml", ".yml", ""}
NOT_OURS = {"LICENSE", "test/test_words.py"}
DOUBLED = "the|a|an|is|are|to|of|in|and|it|with|for|by|at|be|as|on|from"

# What to look for (a space may be a line break), and what to write instead.
PLAIN = {
    # nodes, vehicles and files are things
    r"(?:[.:;|] |\*\*|\"\"\"\s*|- |\n\n)Who (?!\w+ whom)\w+": "If a scenario ..., a node that ...",
    r"\b(?:of|than|by|interrupts) who (?!\w+ whom)\w+\b": "the thing: a node that ...",
    r"\b(?:those|each|everybody|everyone|nobody|only) who\b": "each node that ..., the vehicles that ...",
    r"\b(?:he|him|his)\b": "it, its, or the name of the thing",
    r"\bbeliefs? of who(?:m|se)?\b": "neighbour estimate",
    r"\b(?:who|whom)(?:so)?ever\b": "any program that ..., whichever process ...",
    # words of another age
    r"\bshall\b": "must, will, or the present tense",
    r"\bwherever they\b": "on any host, in any folder",
    r"\bfor ever\b": "forever, without end",
    r"\b(?:bereft|lest|nought|naught|hither|thither|yonder)\b": "a word of today",
    r"\b(?:till|upon|whilst|amongst|hence)\b": "until, on, while, among, so",
    r"\b(?:thereof|therein|thereto|wherein|whereby|whereof|hereby)\b": "of it, in which, by which",
    r"\b(?:whatsoever|howsoever|notwithstanding|must needs)\b": "whatever, however, despite, must",
    r"\bbeforehand\b": "before, in advance",
    r"\bheed(?:s|ed|ing)?\b": "use, obey",
    r"\bin order to\b": "to",
    r"\b(?:end|ends|ended|leave|leaves|finish|finishes|shut down|stops?) in order\b": "cleanly",
    # turns that have to be read twice
    r"\b(?:at most|within|for|after|left|be|of|up to) so long\b(?! as)": "at most this time, this long",
    r"\bwhat was asked for beside\b": "the target beside",
    r"\b(?:comes?|came|become|became) of (?:it|this|that)\b": "result, outcome",
    r"\bstands? in\b(?! for)|\bstands? here\b|\bas it stands\b": "is in, is here",
    r"\btakes? no hurry\b": "is not urgent",
    r"\bgets? a word in\b": "transmits",
    r"\blooks? on\b": "observes",
    # words of the field
    r"\bconfidence bands?\b": "confidence interval",
    r"\bgrowths? of (?:the )?(?:integrals?|integral states?)\b": "integral state",
    # slips
    rf"\b({DOUBLED})[\x20\n]+\1\b": "the word once",
}
# The changelog keeps the words of its time.
PLAIN_TODAY = {
    r"(?<!\t)\b(?:[Nn]o|[Ee]very|[Ss]ome|[Aa]ny)body\b(?!\t)": "no vehicle, every node, a person",
    r"\b[Bb]eliev(?:es?|ed|ing)\b": "estimate, assume, accept",
    r"\b[Mm]end(?:s|ed|ing)?\b(?!\.py|_)": "repair, correct",
    r"\bamounts? to\b": "summary, metrics, result",
    r"\bwhat (?:came|comes?|becomes?|became) of\b": "result, outcome",
    r"\b(?:None|NaN|inf) where\b": "if",
    r"\b[Rr]aises? \w+(?:, one line,)? where\b": "if",
    r"\bwhole or not at all\b": "completely or not at all",
}
# Names in the source are still these.
PLAIN_PAGES = {r"\b[Ss]trangers?\b": "another program, a foreign process", r"\b[Bb]eliefs?\b": "estimate"}
KEPT_AS_WRITTEN = {"CHANGELOG.md", "CODE_OF_CONDUCT.md"}


def compiled(turns):
    return {re.compile(turn.replace(" ", r"\s+")): better for turn, better in turns.items()}


PATTERNS, PATTERNS_TODAY, PATTERNS_PAGES = compiled(PLAIN), compiled(PLAIN_TODAY), compiled(PLAIN_PAGES)


def patterns_of(name):
    """Return what to look for in a file."""
    if name in KEPT_AS_WRITTEN:
        return PATTERNS
    return PATTERNS | PATTERNS_TODAY | (PATTERNS_PAGES if name.endswith(".md") else {})


def files():
    """Return the names of the files in the tree whose prose is ours."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    if listed.returncode:
        return []
    names = [name for name in listed.stdout.splitlines() if Path(name).suffix in PROSE]
    return [name for name in names if name not in NOT_OURS and (ROOT / name).is_file()]


def blank(text):
    """Return spaces in place of a text; its lines stay."""
    return re.sub(r"[^\n]", " ", text)


def prose_of_python(text):
    """Return a module with its code blanked out: comments and strings are left, at their places."""
    lines = text.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))
    prose = list(blank(text))
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        name = tokenize.tok_name[token.type]
        if name in {"COMMENT", "STRING", "FSTRING_MIDDLE"}:
            first = starts[token.start[0] - 1] + token.start[1]
            prose[first : first + len(token.string)] = unquoted(token.string)
    return without_code("".join(prose))


def without_code(text):
    """Return a text with tabs in place of the words in backticks."""
    return re.sub(r"`[^`\n]*`", lambda found: "\t" * len(found[0]), text)


def unquoted(token):
    """Return a comment or string without its marks: quotes become tabs, but for those of docstrings."""
    if token.startswith("#"):
        return " " + token[1:]
    return token if '"""' in token else re.sub("[\"']", "\t", token)


def prose_of_markdown(text):
    """Return a page with code blanked out."""
    text = re.sub(r"^```.*?^```", lambda found: blank(found[0]), text, flags=re.MULTILINE | re.DOTALL)
    return without_code(text)


def prose_of(name, text):
    if name.endswith(".py"):
        return prose_of_python(text)
    if name.endswith(".md"):
        return prose_of_markdown(text)
    return re.sub(r"^(\s*)#", r"\1 ", text, flags=re.MULTILINE)


def slips(name, text):
    """Return a line for each turn in a text that has a plainer one."""
    prose = prose_of(name, text)
    found = [
        (better, each) for pattern, better in patterns_of(name).items() for each in pattern.finditer(prose)
    ]
    return [
        f"{name}:{prose.count(chr(10), 0, each.end()) + 1}: {turn_of(each)!r}; better: {better}"
        for better, each in found
    ]


def turn_of(found):
    """Return what was found, on one line and without the marks around it."""
    return " ".join(found[0].split()).strip('.:;|*- "')


def test_the_prose_is_plain_english():
    names = files()
    if not names:
        pytest.skip("no git repository here: what belongs to the tree is not known")
    assert {"README.md", "scripts/setup", "src/auv_flocking/auv_flocking/agent.py"} <= set(names)
    found = [line for name in names for line in slips(name, (ROOT / name).read_text(encoding="utf-8"))]
    assert not found, "\n" + "\n".join(found)


@pytest.mark.parametrize(
    ("name", "text", "turn"),
    [
        ("a.md", "It works.\n\nWho names no law gets one.\n", "Who names"),
        ("a.md", "Nodes live wherever\nthey are.\n", "wherever they"),
        ("a.py", '"""Nobody interrupts who wakes him."""\n', "him"),
        ("a.py", "# the nodes that it\n# shall start\nx = 1\n", "shall"),
        ("a.py", 'x = f("hold at most so "\n  "long until (s)")\n', "at most so long"),
        ("a.py", "f'{x} of the the run'\n", "the the"),
        ("scripts/a", "# This stands\n# in the file\n", "stands in"),
        ("docs/a.md", "A vehicle believes its navigation.\n", "believes"),
        ("a.py", '"""Return the time, None where it is\n    unknown."""\n', "None where"),
        ("a.py", "# Nobody waits.\n", "Nobody"),
    ],
)
def test_a_slip_is_found_at_its_place(name, text, turn):
    assert any(repr(turn) in line for line in slips(name, text))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.py", "he = shall(his)\n"),
        ("a.py", "mend_bag(nobody)\n"),
        ("a.md", "Call `he.shall()`.\n\n```python\nhe = 1\n```\n"),
        ("a.md", "A graph of who hears whom; it stands in for the thesis's.\n"),
    ],
)
def test_code_is_not_prose(name, text):
    assert slips(name, text) == []
