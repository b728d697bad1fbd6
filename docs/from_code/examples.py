"""The programs of the folder `examples`, as they are."""

from __future__ import annotations

from pathlib import Path


def examples(folder: Path) -> str:
    """Return all programs of a folder."""
    return "\n".join(
        f'```python title="{path.relative_to(folder.parent)}"\n{path.read_text(encoding="utf-8")}```\n'
        for path in sorted(folder.rglob("*.py"))
    )
