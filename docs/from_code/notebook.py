"""A notebook as a page: run when the site is built, and shown with what its cells gave."""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import nbformat
from nbclient import NotebookClient
from traitlets.config import Config

CELL_LIMIT_S = 120


class Page(NamedTuple):
    """The text of a page, and its images by file name."""

    markdown: str
    images: dict[str, bytes]


def notebook_page(path: Path) -> Page:
    """Return the page of a notebook; raise nbclient's CellExecutionError where a cell fails."""
    return _page(path.stem, path.read_text(encoding="utf-8"))


@cache
def _page(name: str, text: str) -> Page:
    notebook = nbformat.reads(text, as_version=4)
    with tempfile.TemporaryDirectory() as place:
        # The kernel is reached by sockets in this folder, whose path is short enough for them, not by ports.
        sockets = {"transport": "ipc", "connection_file": f"{place}/kernel.json"}
        config = Config({"KernelManager": sockets})
        NotebookClient(notebook, timeout=CELL_LIMIT_S, kernel_name="python3", config=config).execute()
    images: dict[str, bytes] = {}
    parts = []
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```python\n{cell.source}\n```")
        for output in cell.outputs:
            parts += _shown(output, name, images)
    return Page("\n\n".join(parts) + "\n", images)


def _shown(output: Any, name: str, images: dict[str, bytes]) -> Iterator[str]:
    """Yield what one output of a cell looks like; an image goes into `images`."""
    if output.output_type == "stream":
        if output.name == "stdout":
            yield f"```text\n{output.text.rstrip()}\n```"
        return
    data = output.data
    if "image/png" in data:
        file = f"{name}_{len(images) + 1}.png"
        images[file] = base64.b64decode(data["image/png"])
        yield f"![{data['text/plain']}]({file})"
    elif "text/html" in data:
        yield f'<div class="output">\n{data["text/html"]}\n</div>'
    else:
        yield f"```text\n{data['text/plain']}\n```"
