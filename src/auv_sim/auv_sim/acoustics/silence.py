"""An interval in which no packet arrives at any modem, whatever the outage is otherwise."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.params import param


@dataclass(frozen=True, kw_only=True)
class Silence:
    """From a time up to another one; by default it is empty."""

    from_s: float = param("time from which packets are lost (s)", default=0.0, minimum=0.0)
    until_s: float = param("time from which they arrive again (s)", default=0.0, minimum=0.0)

    def __post_init__(self) -> None:
        if self.until_s < self.from_s:
            raise ValueError(
                f"until_s: {self.until_s!r} is not allowed; allowed: at least from_s = {self.from_s!r}"
            )

    def covers(self, t_s: float) -> bool:
        """Return whether a packet is lost that begins to arrive at a time (s)."""
        return self.from_s <= t_s < self.until_s


NO_SILENCE = Silence()
