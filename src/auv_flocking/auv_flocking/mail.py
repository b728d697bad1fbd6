"""Inputs of an agent in real time between its steps: the newest navigation, and several inboxes as one."""

from __future__ import annotations

from auv_core.freshness import Newest, age_limit_s
from auv_core.messages import Inbox, Reception, SonarContact, VehicleState
from auv_flocking.input_limits import InputLimits


class Mail:
    """
    Collects navigations and inboxes for the next step.

    `navs` and `inboxes` tell what was dropped. A packet is used at any age, since it carries its own time.
    Sonar contacts and requests of the modem are only used while they are fresh.
    """

    def __init__(self, limits: InputLimits, period_s: float) -> None:
        self.navs: Newest[VehicleState] = Newest(age_limit_s(limits.nav_max_age_s, period_s), period_s)
        self.inboxes: Newest[Inbox] = Newest(age_limit_s(limits.inbox_max_age_s, period_s), period_s)
        self._receptions: list[Reception] = []
        self._contacts: tuple[SonarContact, ...] = ()
        self._ready_tick: int | None = None

    @property
    def nav(self) -> VehicleState | None:
        """The newest navigation, if any."""
        return self.navs.value

    def start(self, tick: int) -> None:
        """Start to wait for inputs at a tick."""
        self.navs.start(tick)
        self.inboxes.start(tick)

    def awaits_first(self, tick: int) -> bool:
        """Return whether no navigation has come yet and it is not late."""
        return self.navs.value is None and not self.navs.why_stale(tick)

    def hear_inbox(self, inbox: Inbox, now_tick: int) -> None:
        """Take an inbox."""
        if inbox.tick <= now_tick or not self.inboxes.why_stale(now_tick, inbox.tick):
            self._receptions += inbox.receptions
        if not self.inboxes.hear(inbox, inbox.tick, now_tick) or self.inboxes.why_stale(now_tick):
            return
        self._contacts = inbox.contacts or self._contacts
        if inbox.transmit_ready:
            self._ready_tick = inbox.tick

    def take_inbox(self) -> Inbox:
        """
        Return the data since the last call as one inbox, of the newest tick with a request of the modem.
        """
        tick = self.inboxes.tick if self._ready_tick is None else self._ready_tick
        inbox = Inbox(tick, self._ready_tick is not None, tuple(self._receptions), self._contacts)
        self._receptions, self._contacts, self._ready_tick = [], (), None
        return inbox
