"""
ROS 2 domains: a run of its own domain, so that two runs on one machine do not hear each other.

A run uses $ROS_DOMAIN_ID (0 if unset), where the user's own tools look. When another run holds that domain,
the next free one is taken. A domain is held by a lock (flock) on a small file in the machine's temporary
folder; the kernel drops the lock when its process ends, however it ends, so nothing is ever left to clean
up.
"""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType

LOCK_FOLDER_NAME = "shoal-domains"
SAFE_DOMAIN_IDS = (*range(102), *range(215, 233))
"""Domains whose UDP ports lie outside the range from which Linux takes the ports of outgoing connections."""
_SAFE_WORDS = "a whole number from 0 to 101 or from 215 to 232"


class DomainError(ValueError):
    """No domain can be used as asked; the message is one line for the user."""


@dataclass
class DomainClaim:
    """
    A domain held by this process until `release`, or until the process ends.

    `domain_id` is the domain held, `asked_id` the one that was asked for.
    """

    domain_id: int
    asked_id: int
    _descriptor: int = field(repr=False)

    @property
    def is_moved(self) -> bool:
        """Whether the domain asked for was taken by another run."""
        return self.domain_id != self.asked_id

    def release(self) -> None:
        """Give the domain back; a second call does nothing."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def __enter__(self) -> DomainClaim:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.release()


def claim_domain(environ: Mapping[str, str], lock_dir: Path | None = None) -> DomainClaim:
    """
    Hold the domain of $ROS_DOMAIN_ID, or the next one that no other run holds.

    Parameters
    ----------
    environ : mapping
        Environment variables.
    lock_dir : Path, optional
        Folder of the lock files; by default one folder per machine.

    Raises
    ------
    DomainError
        When the variable holds no domain, or no domain is free.

    """
    asked_id = asked_domain(environ)
    folder = lock_dir or Path(tempfile.gettempdir()) / LOCK_FOLDER_NAME
    _make_shared_folder(folder)
    start = SAFE_DOMAIN_IDS.index(asked_id)
    for domain_id in SAFE_DOMAIN_IDS[start:] + SAFE_DOMAIN_IDS[:start]:
        descriptor = _try_lock(folder / f"{domain_id}.lock")
        if descriptor is not None:
            return DomainClaim(domain_id, asked_id, descriptor)
    raise DomainError(
        f"all {len(SAFE_DOMAIN_IDS)} ROS domains of this machine are in use (locks in {folder})"
    )


def asked_domain(environ: Mapping[str, str]) -> int:
    """Return the domain that $ROS_DOMAIN_ID asks for; 0 when it is unset or empty."""
    text = environ.get("ROS_DOMAIN_ID", "").strip() or "0"
    if not (text.isascii() and text.isdecimal()) or int(text) not in SAFE_DOMAIN_IDS:
        raise DomainError(f"ROS_DOMAIN_ID: {text!r} is not allowed; allowed: {_SAFE_WORDS}")
    return int(text)


def _make_shared_folder(folder: Path) -> None:
    """Make a folder in which every user of the machine can make files, and remove only their own."""
    try:
        folder.mkdir(parents=True)
        folder.chmod(0o1777)
    except FileExistsError:
        pass
    except OSError as error:
        raise DomainError(
            f"{folder}: cannot be made ({error.strerror}); it holds the locks of ROS domains"
        ) from None


def _try_lock(path: Path) -> int | None:
    """Return a descriptor that holds the lock on `path`, None if another process holds it."""
    # Another user's file can be opened for reading only; flock needs no more.
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
    except FileNotFoundError:
        try:
            descriptor = os.open(path, os.O_RDONLY | os.O_CREAT | os.O_NOFOLLOW, 0o644)
        except OSError as error:
            raise DomainError(
                f"{path}: cannot be made ({error.strerror}); it is the lock of a ROS domain"
            ) from None
    except OSError:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        return None
    return descriptor
