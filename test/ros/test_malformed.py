"""For any bytes under a message type's name, a node reads a record or drops them."""

from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytestmark = pytest.mark.ros


@st.composite
def mutations(draw, messages):
    """Return one of some serialised messages with bytes changed, cut off, put in or added."""
    data = bytearray(draw(st.sampled_from(messages)))
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(data)))
        change = draw(st.sampled_from(("set", "cut", "put", "fill")))
        if change == "cut":
            del data[at:]
        elif change == "put":
            data[at:at] = draw(st.binary(max_size=12))
        elif change == "fill":
            data[at : at + 8] = draw(st.sampled_from((b"\xff" * 8, b"\0" * 8, b"\x7f" * 4)))
        else:
            data[at : at + 1] = draw(st.binary(min_size=1, max_size=1))
    return bytes(data)


def readers():
    """Return by name what reads a kind of message, and messages of that kind."""
    from rclpy.serialization import serialize_message

    from auv_core.messages import Inbox, Packet, Reception, SonarContact
    from auv_msgs.msg import FlockStatus
    from auv_ros.hearing import decoded
    from auv_ros.wire import conversions as convert
    from auv_ros.wire.acoustics import inbox_bytes, outbox_bytes, read_inbox, read_outbox
    from auv_ros.wire.commands import command_bytes, command_from_bytes

    packet = Packet(3, 1, 0, 2, b"0123456789")
    inbox = Inbox(4, True, (Reception(packet, 0.1, 0.2, 9.0),) * 2, (SonarContact(1.0, 0.1, 0.2),) * 2)
    state = convert.state_stencil().filled(1.0, 7, True, True, *[0.5] * 15)
    wrench = command_bytes("auv_1", "wrench", 1.0, *[2.0] * 6)
    forces = command_bytes("auv_1", "thrusters", 1.0, *[2.0] * 8)
    status = FlockStatus(state="running", lost_vehicles=["auv_2"], detail="words")
    return {
        "state": (convert.state_from_bytes, [state]),
        "command": (lambda data: command_from_bytes(data, "wrench", 6), [wrench]),
        "forces": (lambda data: command_from_bytes(data, "thrusters", 8), [forces]),
        "inbox": (
            lambda data: read_inbox(data, 0),
            [inbox_bytes("auv_1", inbox, 1.0, 0), inbox_bytes("", Inbox(1, False, ()), 0.0, 0)],
        ),
        "outbox": (read_outbox, [outbox_bytes("auv_1", 7, [packet, packet], 1.0)]),
        "status": (lambda data: decoded(FlockStatus, data), [serialize_message(status)]),
    }


@pytest.mark.parametrize("name", ["state", "command", "forces", "inbox", "outbox", "status"])
def test_bytes_that_are_no_message_are_never_more_than_a_value_error(name):
    read, messages = readers()[name]
    for message in messages:
        read(message)
        for short in range(len(message) - 4):
            with pytest.raises(ValueError, match="bytes"):
                read(message[:short])
        if name != "status":  # what the client library reads may be longer, and of the other byte order
            for wrong in (message + bytes(4), b"\0\0" + message[2:]):
                with pytest.raises(ValueError, match="bytes"):
                    read(wrong)

    @settings(deadline=None, max_examples=300)
    @given(data=st.one_of(mutations(messages), st.binary(max_size=200)))
    def check(data):
        with suppress(ValueError):
            read(data)

    check()


def test_a_message_of_the_run_with_padding_at_its_end_is_read():
    from auv_ros.wire import conversions as convert

    state = convert.state_stencil().filled(1.0, 7, True, True, *[0.5] * 15)
    assert convert.state_from_bytes(state + bytes(3)) == convert.state_from_bytes(state)


def test_a_node_counts_what_it_leaves_out_and_hears_what_follows():
    from ros_desk import desk

    from auv_msgs.msg import VehicleState
    from auv_ros.hearing import Hearing
    from auv_ros.qos import EVERY_TICK
    from auv_ros.wire import conversions as convert

    state = convert.state_stencil().filled(1.0, 7, True, True, *[0.5] * 15)
    with desk() as at:
        publisher = at.publisher(VehicleState, "said")
        hearing, heard = Hearing(at.node), []
        hearing.listen(
            VehicleState, "said", lambda data: heard.append(convert.state_from_bytes(data)), EVERY_TICK
        )
        at.until(lambda: publisher.get_subscription_count() == 1, "discovery")
        for data in (state[:-9], b"\0\0" + state[2:], state):
            publisher.publish(data)
        at.until(lambda: heard, "the message")
    assert [each.tick for each in heard] == [7]
    assert hearing.malformed == {"/said": 2}
