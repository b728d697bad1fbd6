"""Full disks: the kernel refuses files of more than a few bytes, or a tiny disk is filled."""

import resource
import subprocess
import sys
from contextlib import contextmanager

import pytest

_TINY_DISK = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c"]
_FILLED = """
import sys
from pathlib import Path

def fill():
    with Path(disk, "filling").open("wb", buffering=0) as stream:
        try:
            while True:
                stream.write(bytes(512))
        except OSError:
            return

disk = Path(sys.argv[1])
"""


@contextmanager
def files_of_at_most(size_bytes):
    """Let every write of this process beyond so many bytes of a file fail, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size_bytes, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def on_a_tiny_disk(folder, code):
    """Run code that finds a disk of 256 kB at `disk` and can `fill()` it; return what it prints."""
    mount = f'mount -t tmpfs -o size=256k tmpfs "{folder}"'
    if subprocess.run([*_TINY_DISK, mount], capture_output=True, check=False).returncode:
        pytest.skip("no disk can be mounted here")
    command = [*_TINY_DISK, f'{mount} && exec "$0" "$@"', sys.executable, "-c", _FILLED + code, str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60.0)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout
