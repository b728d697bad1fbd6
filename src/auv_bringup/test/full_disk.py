"""A disk that is full, without one: the kernel refuses files of more than a few bytes."""

import resource
from contextlib import contextmanager


@contextmanager
def files_of_at_most(size_bytes):
    """Let every write of this process beyond so many bytes of a file fail, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size_bytes, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
