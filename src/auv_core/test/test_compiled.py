"""Compiled twins give the numbers of their plain source, and are found again in a later process."""

import os
import subprocess
import sys

import pytest

from auv_core import compiled

_PROGRAM = """
import sys
from auv_core import compiled
from auv_core.models import six_dof
from auv_core.models.six_dof import Model, advance
from auv_core.params import load
from auv_core.models import presets
import yaml, pathlib
numbers = yaml.safe_load((pathlib.Path(presets.__path__[0]) / "odin.yaml").read_text())["params"]
compiled.use_compiler()
model = Model(load(six_dof.Params, numbers, "odin"))
state = model.initial_state((1.0, -2.0, 3.0), 0.7)
for command in ((60.0, -20.0, 9.0, 5.0, -8.0, 3.0), (-100.0, 40.0, 2.0, 0.0, 1.0, -9.0)):
    state = model.step(state, command, (0.1, -0.2, 0.05), 0.02, 200)
print([number.hex() for number in state])
twin = compiled.fastest(advance)
print(compiled.is_compiling(), getattr(getattr(twin, "stats", None), "cache_hits", None), file=sys.stderr)
"""


def _run(**environment):
    env = {**os.environ, **environment}
    return subprocess.run(
        [sys.executable, "-c", _PROGRAM], env=env, capture_output=True, text=True, timeout=120, check=True
    )


def test_compiled_and_plain_give_the_same_numbers_to_the_last_bit(tmp_path):
    first = _run(XDG_CACHE_HOME=str(tmp_path))
    plain = _run(NUMBA_DISABLE_JIT="1")
    assert "True" in first.stderr
    assert "False" in plain.stderr
    assert first.stdout == plain.stdout
    kept = list((tmp_path / "shoal").rglob("*.nbi"))
    again = _run(XDG_CACHE_HOME=str(tmp_path))
    assert again.stdout == plain.stdout
    assert list((tmp_path / "shoal").rglob("*.nbi")) == kept


def test_nothing_is_compiled_where_nobody_asked():
    function = compiled.entry("float64(float64)")(lambda x: x)
    if not compiled.is_compiling():
        assert compiled.fastest(function) is function


@compiled.inner
def _doubled(x):
    return _FACTOR * x


_FACTOR = 2.0


@compiled.entry("float64(float64)")
def _once_more(x):
    return _doubled(_doubled(x))


def test_the_version_follows_what_an_entry_calls(monkeypatch):
    used = compiled._used(_once_more)
    assert used == {_once_more, _doubled}
    before = compiled._version(used)
    monkeypatch.setitem(_doubled.__globals__, "_FACTOR", 3.0)
    assert compiled._version(used) != before


def test_a_folder_that_cannot_be_written_is_done_without(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert compiled._cache_folder("0123") is None


@pytest.mark.parametrize("n", [3, 6, 13])
def test_tuples_have_short_names(n):
    numba = pytest.importorskip("numba")
    signature = compiled._signature(f"float64(TUPLE{n})")
    assert signature.args == (numba.types.UniTuple(numba.types.float64, n),)


def test_who_waits_for_the_compiler_is_told_once(tmp_path):
    program = (
        "from auv_core import compiled\n"
        "from auv_core.models.six_dof import advance, limited_wrench\n"
        "compiled.use_compiler(tell=print)\n"
        "compiled.fastest(limited_wrench), compiled.fastest(advance)\n"
    )
    said = [
        subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "XDG_CACHE_HOME": str(tmp_path)},
            capture_output=True,
            text=True,
            timeout=120,
            check=True,
        ).stdout
        for _ in range(2)
    ]
    assert len(said[0].splitlines()) == 1
    assert said[1] == ""
