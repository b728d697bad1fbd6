"""Free memory of this process."""

from __future__ import annotations

import math
from pathlib import Path

import psutil

try:
    import resource
except ImportError:
    resource = None  # type: ignore[assignment]

_RESERVED_BYTES = 200e6
"""Address space that libraries reserve beyond the memory that they use; it counts against `ulimit -v`."""
_CGROUPS = Path("/sys/fs/cgroup")
_CGROUP_FILES = (("memory.max", "memory.current"), ("memory.limit_in_bytes", "memory.usage_in_bytes"))


def free_bytes() -> float:
    """Return the memory that this process may still take (bytes), by machine, control group and limits."""
    free = float(psutil.virtual_memory().available)
    for group in _control_groups():
        for limit, usage in _CGROUP_FILES:
            if (group / limit).is_file():
                free = min(free, _number(group / limit) - _number(group / usage))
    if (limit_bytes := _address_limit_bytes()) < math.inf:
        free = min(free, limit_bytes - psutil.Process().memory_info().vms - _RESERVED_BYTES)
    return max(free, 0.0)


def _address_limit_bytes() -> float:
    """Return the limit of this process's address space (`ulimit -v`), infinity if there is none."""
    if resource is None:
        return math.inf
    limit_bytes, _ = resource.getrlimit(resource.RLIMIT_AS)
    return math.inf if limit_bytes == resource.RLIM_INFINITY else limit_bytes


def _control_groups() -> list[Path]:
    """Return the folders of this process's memory control groups and of their parents."""
    try:
        lines = Path("/proc/self/cgroup").read_text().splitlines()
    except OSError:
        return []
    folders = []
    for line in lines:
        _, controllers, path = line.split(":", 2)
        if controllers in ("", "memory"):
            group = _CGROUPS / controllers / path.lstrip("/")
            folders += [group, *group.parents]
    return [folder for folder in folders if folder.is_relative_to(_CGROUPS)]


def _number(path: Path) -> float:
    """Return the number in a file of a control group; other content, such as `max`, means no limit."""
    try:
        return float(path.read_text())
    except (OSError, ValueError):
        return math.inf if "usage" not in path.name and "current" not in path.name else 0.0


def gigabytes(size_bytes: float) -> str:
    """Return a size as text."""
    return f"{size_bytes / 1e9:.3g} GB"
