"""The plugin folders and their contracts: directives by which mkdocstrings writes them out."""

from __future__ import annotations

import importlib
import json

from from_code.keys import plugin_folders

OWN = ("auv_experiment.metrics", "auv_experiment.figures")
"""Folders of a user's own files, which no key of a scenario chooses from."""


def plugins() -> str:
    """Return all plugin folders, each with its contracts."""
    return "\n".join(map(_part, (*plugin_folders(), *OWN)))


def contracts_of(folder: str) -> list[str]:
    """Return the names of the contracts that the package of a folder states."""
    members = vars(importlib.import_module(folder)).items()
    return [
        name
        for name, it in members
        if getattr(it, "_is_protocol", False) and it.__module__ == folder and not name.startswith("_")
    ]


def _part(folder: str) -> str:
    options = {
        "heading": folder.replace(".", "/"),
        "toc_label": folder.rpartition(".")[2],
        "members": contracts_of(folder),
    }
    return f"::: {folder}\n    options: {json.dumps(options)}\n"
