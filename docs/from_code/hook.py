"""The hook of MkDocs that puts into pages what is made from code, and makes pages of notebooks."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from from_code.commands import commands
from from_code.examples import examples
from from_code.keys import scenario_keys, study_keys
from from_code.messages import messages
from from_code.metrics import metrics
from from_code.notebook import notebook_page
from from_code.plugins import plugins
from from_code.topics import topics

ROOT = Path(__file__).parents[2]
PARTS: dict[str, Callable[[], str]] = {
    "scenario_keys": scenario_keys,
    "study_keys": study_keys,
    "metrics": metrics,
    "plugins": plugins,
    "topics": topics,
    "messages": lambda: messages(ROOT / "src/auv_msgs/msg"),
    "examples": lambda: examples(ROOT / "examples"),
    "commands": lambda: commands(ROOT),
}
_ASKED_FOR = re.compile(r"<!-- from code: (\w+) -->")


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return the text of a page with the parts that it asks for."""
    return _ASKED_FOR.sub(lambda found: PARTS[found[1]](), markdown)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the page of each notebook, and its images, beside the notebook itself."""
    for file in [file for file in files if file.src_uri.endswith(".ipynb")]:
        page = notebook_page(Path(config.docs_dir, file.src_uri))
        folder = Path(file.src_uri).parent
        files.append(File.generated(config, file.src_uri.replace(".ipynb", ".md"), content=page.markdown))
        for name, image in page.images.items():
            files.append(File.generated(config, (folder / name).as_posix(), content=image))
    return files
