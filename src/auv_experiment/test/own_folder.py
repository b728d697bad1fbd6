"""Folders of own metrics and figures for tests, which leave nothing behind in this process."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest


class OwnFolder:
    """A folder of `SHOAL_PLUGINS`, and what Python remembers of it."""

    def __init__(self, root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self._root = root
        monkeypatch.setenv("SHOAL_PLUGINS", str(root))
        for kind in ("metrics", "figures"):
            (root / kind).mkdir(parents=True)

    def write(self, kind: str, name: str, text: str) -> None:
        """Write the file ``<kind>/<name>.py``."""
        (self._root / kind / f"{name}.py").write_text(text, encoding="utf-8")
        importlib.invalidate_caches()

    def forget(self) -> None:
        """Let Python forget the folder."""
        for name, module in list(sys.modules.items()):
            if str(getattr(module, "__file__", None)).startswith(str(self._root)):
                del sys.modules[name]
                package, _, word = name.rpartition(".")
                delattr(sys.modules[package], word)
        for kind in ("metrics", "figures"):
            path = importlib.import_module(f"auv_experiment.{kind}").__path__
            path[:] = [place for place in path if not place.startswith(str(self._root))]
