"""Claims about what reaches an agent in real time, whatever order it comes in."""

import math

from auv_core.messages import Inbox, Packet, Reception, SonarContact, VehicleState
from auv_flocking.input_limits import InputLimits
from auv_flocking.mail import Mail

SEEN = (SonarContact(3.0, 0.0, 0.0),)


def mail():
    return Mail(InputLimits(), 0.1)


def reception(number):
    return Reception(Packet(0, 2, 0, number, b""), 0.0, 0.0, math.nan)


def nav(tick):
    return VehicleState(tick, (0.0, 0.0, 10.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 6)


def test_many_inboxes_are_one_of_the_tick_in_which_the_modem_asks():
    box = mail()
    box.hear_inbox(Inbox(3, True, (reception(1),), SEEN), 3)
    box.hear_inbox(Inbox(4, False, (reception(2),)), 4)
    assert box.take_inbox() == Inbox(3, True, (reception(1), reception(2)), SEEN)
    assert box.take_inbox() == Inbox(4, False, ())


def test_packets_count_however_late_they_come_but_contacts_and_slots_do_not():
    box = mail()
    box.hear_inbox(Inbox(3, True, (reception(1),), SEEN), 20)
    assert box.take_inbox() == Inbox(3, False, (reception(1),))


def test_an_inbox_of_a_far_tick_is_dropped_whole():
    box = mail()
    box.hear_inbox(Inbox(10**9, True, (reception(1),), SEEN), 1)
    box.start(1)
    assert box.take_inbox() == Inbox(1, False, ())
    assert box.inboxes.dropped == 1


def test_an_agent_waits_for_its_first_navigation_but_not_for_ever():
    box = mail()
    box.start(100)
    assert box.awaits_first(105)
    assert not box.awaits_first(106)
    box.navs.hear(nav(106), 106, 106)
    assert not box.awaits_first(106)
    assert box.nav == nav(106)
