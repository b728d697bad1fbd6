"""
Turn a venv that holds the ROS 2 wheels from PyPI into a prefix that colcon can build on.

Run by the venv's own interpreter, after every installation into it; standard library only. Two repairs, both
idempotent:

* The CMake files of the message packages name include folders of the machine that the wheels were made on.
  CMake refuses to build against folders that do not exist, so these entries go; rosidl_generator_py finds the
  right ones itself.
* The prefix gets `local_setup.{sh,bash,zsh}`, as /opt/ros/jazzy has them. colcon chains every workspace to
  them, so that `source install/setup.bash` alone, in any shell, brings up the venv, the wheels and the
  workspace.

Files may be hard links into the installer's cache, shared with other venvs: they are replaced, never written
to.
"""

import os
import re
import shlex
import sys
from pathlib import Path

# Include folders of the machine that made the wheels, e.g. `/opt/python/cp311-cp311/include/python3.11`.
FOREIGN_INCLUDE = re.compile(r'/opt/python/[^;"]*')
INCLUDE_PROPERTY = re.compile(r'^(\s*INTERFACE_INCLUDE_DIRECTORIES\s+)"([^"]*)"', re.MULTILINE)

LOCAL_SETUP = """\
# Environment of the ROS 2 wheels in this venv. Written by scripts/prepare_venv.py.

_shoal_prepend() {{  # NAME VALUE: put VALUE in front of the list in $NAME, once
  eval "_shoal_old=\\"\\${{$1:-}}\\""
  case ":$_shoal_old:" in
    *":$2:"*) ;;
    *) eval "export $1=\\"\\$2\\${{_shoal_old:+:\\$_shoal_old}}\\"" ;;
  esac
}}

export VIRTUAL_ENV={prefix}
export ROS_DISTRO=jazzy
export ROS_VERSION=2
export ROS_PYTHON_VERSION=3
# The wheels start every Python twice to set LD_LIBRARY_PATH, unless this says that it is set.
export _ROS_WHEELS_BOOTSTRAP_COMPLETE=1
_shoal_prepend PATH "$VIRTUAL_ENV/bin"
_shoal_prepend AMENT_PREFIX_PATH "$VIRTUAL_ENV"
_shoal_prepend CMAKE_PREFIX_PATH "$VIRTUAL_ENV"
{library_lines}
unset -f _shoal_prepend
unset _shoal_old
"""


def replace(path: Path, text: str) -> None:
    """Write `text` to `path` as a new file, so that hard links of the old one keep their content."""
    fresh = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    fresh.write_text(text, encoding="utf-8")
    fresh.replace(path)


def without_foreign_includes(cmake_text: str) -> str:
    """Return the text of a CMake export file without include folders of another machine."""

    def kept(match: re.Match) -> str:
        folders = [folder for folder in match[2].split(";") if not FOREIGN_INCLUDE.fullmatch(folder)]
        return f'{match[1]}"{";".join(folders)}"'

    return INCLUDE_PROPERTY.sub(kept, cmake_text)


def mend_cmake_exports(prefix: Path) -> int:
    """Drop foreign include folders from the CMake exports under `prefix`; return how many files changed."""
    changed = 0
    for path in sorted(prefix.glob("share/*/cmake/*Export.cmake")):
        text = path.read_text(encoding="utf-8")
        mended = without_foreign_includes(text)
        if mended != text:
            replace(path, mended)
            changed += 1
    return changed


def library_folders(prefix: Path) -> list[Path]:
    """Return the folders of shared libraries, those that must come first in LD_LIBRARY_PATH first."""
    return [prefix / "lib", *sorted(prefix.glob("lib/python3.*/site-packages/ros_*.libs"))]


def write_local_setup(prefix: Path) -> None:
    """Write `local_setup.{sh,bash,zsh}` into `prefix`."""
    # Each line prepends, so the one that must come first is written last.
    library_lines = "\n".join(
        f'_shoal_prepend LD_LIBRARY_PATH "$VIRTUAL_ENV/{folder.relative_to(prefix)}"'
        for folder in reversed(library_folders(prefix))
    )
    text = LOCAL_SETUP.format(prefix=shlex.quote(str(prefix)), library_lines=library_lines)
    for shell in ("sh", "bash", "zsh"):
        replace(prefix / f"local_setup.{shell}", text)


def main() -> int:
    """Prepare the venv of the running interpreter."""
    prefix = Path(sys.prefix)
    if sys.prefix == sys.base_prefix:
        print("prepare_venv.py: run me with the python of the venv", file=sys.stderr)
        return 2
    mend_cmake_exports(prefix)
    write_local_setup(prefix)
    return 0


if __name__ == "__main__":
    sys.exit(main())
