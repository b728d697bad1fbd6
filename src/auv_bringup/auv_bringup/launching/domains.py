"""
ROS 2 domains: each run has its own domain, so that two runs on one machine do not hear each other.

A run uses $ROS_DOMAIN_ID (0 if unset), where the user's own tools look. If another run of any user holds
that domain, the next free one is taken. The name of a Unix socket in Linux's abstract namespace locks a
domain. Such a name is no file, so it cannot be replaced by a link or a FIFO. It is the same for all users of
a network namespace, as UDP ports are, and the kernel always drops it when its process ends.
"""

from __future__ import annotations

import errno
import os
import socket
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import TracebackType

_NAME = "shoal-domain"
SAFE_DOMAIN_IDS = (*range(102), *range(215, 233))
"""Domains whose UDP ports lie outside the range from which Linux takes the ports of outgoing connections."""
_SAFE_WORDS = "a whole number from 0 to 101 or from 215 to 232"


class DomainError(ValueError):
    """Raised if no domain can be used; the message is one line for the user."""


@dataclass
class DomainClaim:
    """
    A domain held by this process until `release`, or until the process ends.

    `domain_id` is the held domain, `asked_id` the requested one.
    """

    domain_id: int
    asked_id: int
    _descriptor: int = field(repr=False)

    @property
    def is_moved(self) -> bool:
        """Whether another run holds the requested domain."""
        return self.domain_id != self.asked_id

    def release(self) -> None:
        """Release the domain; a second call has no effect."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def __enter__(self) -> DomainClaim:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.release()


def claim_domain(environ: Mapping[str, str], name: str = _NAME) -> DomainClaim:
    """
    Hold the domain of $ROS_DOMAIN_ID, or the next one that no other run holds.

    Parameters
    ----------
    environ : mapping
        Environment variables.
    name : str
        Prefix of the names of all domains.

    Raises
    ------
    DomainError
        If the variable has no valid domain, or no domain is free.

    """
    asked_id = asked_domain(environ)
    start = SAFE_DOMAIN_IDS.index(asked_id)
    for domain_id in SAFE_DOMAIN_IDS[start:] + SAFE_DOMAIN_IDS[:start]:
        held = try_to_hold(domain_id, name)
        if held is not None:
            return DomainClaim(domain_id, asked_id, held)
    raise DomainError(f"all {len(SAFE_DOMAIN_IDS)} ROS domains of this machine are in use by other runs")


def try_to_hold(domain_id: int, name: str = _NAME) -> int | None:
    """
    Return a descriptor that holds a domain until it is closed, None if another process holds the domain.

    Raises
    ------
    DomainError
        If the machine has no such sockets.

    """
    held = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        held.bind(f"\0{name}-{domain_id}")
    except OSError as error:
        held.close()
        if error.errno == errno.EADDRINUSE:
            return None
        raise DomainError(f"ROS domain {domain_id} cannot be held ({error.strerror})") from None
    return held.detach()


def asked_domain(environ: Mapping[str, str]) -> int:
    """Return the domain in $ROS_DOMAIN_ID; 0 if it is unset or empty."""
    text = environ.get("ROS_DOMAIN_ID", "").strip() or "0"
    if not (text.isascii() and text.isdecimal()) or int(text) not in SAFE_DOMAIN_IDS:
        raise DomainError(f"ROS_DOMAIN_ID: {text!r} is not allowed; allowed: {_SAFE_WORDS}")
    return int(text)
