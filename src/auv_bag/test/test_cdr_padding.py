"""Padding is zeroed, and nothing else is touched."""

import os

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from auv_bag.definitions import MessageType
from auv_bag.padding import padding_zeroer

SEPARATOR = "=" * 80 + "\n"
PART = "uint8 small\nfloat64[2] pair\nstring word\n"
WHOLE = f"""int32 LIMIT=3   # a constant
string NAME='a = b'
string first    # text
int64 number
shoal_test/Part[] parts
uint8[] payload
float64[] reals
bool flag
uint16[3] fixed
Part[2] twins
string[] words
float32 last
{SEPARATOR}MSG: shoal_test/Part
{PART}"""
TYPE = MessageType("shoal_test/msg/Whole", WHOLE, "RIHS01_0")


@pytest.fixture(scope="module")
def store():
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(PART, "shoal_test/msg/Part"))
    store.register(get_types_from_msg(WHOLE.split(SEPARATOR)[0].replace("shoal_test/", ""), TYPE.name))
    return store


words = st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=9)


@st.composite
def wholes(draw, store):
    import numpy as np

    part = store.types["shoal_test/msg/Part"]
    make_part = st.builds(
        lambda small, word: part(small, np.array([1.0, -2.0]), word), st.integers(0, 255), words
    )
    return store.types[TYPE.name](
        draw(words),
        draw(st.integers(-(2**63), 2**63 - 1)),
        draw(st.lists(make_part, max_size=3)),
        np.frombuffer(draw(st.binary(max_size=9)), np.uint8),
        np.array(draw(st.lists(st.floats(allow_nan=False), max_size=3))),
        draw(st.booleans()),
        np.array([1, 2, 3], np.uint16),
        [draw(make_part), draw(make_part)],
        draw(st.lists(words, max_size=3)),
        0.5,
    )


@given(data=st.data())
def test_a_message_with_zero_padding_stays_as_it_is(store, data):
    clean = bytes(store.serialize_cdr(data.draw(wholes(store)), TYPE.name))
    assert padding_zeroer(TYPE)(clean) == clean


LAYOUT = MessageType("shoal_test/msg/Layout", "string a\nfloat64 b\nuint8 c\nint32[] d\n", "RIHS01_0")


def layout_message(length, count, fill):
    out = bytearray((length).to_bytes(4, "little") + b"x" * (length - 1) + b"\0")
    out += bytes([fill]) * (-len(out) % 8) + b"8 bytes." + b"c"
    out += bytes([fill]) * (-len(out) % 4) + count.to_bytes(4, "little") + b"four" * count
    return b"\0\1\0\0" + bytes(out)


@given(length=st.integers(1, 20), count=st.integers(0, 3), filler=st.integers(0, 255))
def test_garbage_in_the_padding_goes_and_the_content_stays(length, count, filler):
    message = layout_message(length, count, filler)
    assert padding_zeroer(LAYOUT)(message) == layout_message(length, count, 0)


@given(st.binary(max_size=200))
def test_bytes_that_are_no_such_message_are_none(data):
    found = padding_zeroer(TYPE)(data)
    assert found is None or 0 <= len(data) - len(found) < 4


def test_a_list_of_any_length_is_not_walked_beyond_the_message():
    pairs = f"shoal_test/Pair[] pairs\n{SEPARATOR}MSG: shoal_test/Pair\nuint8 small\nfloat64 large\n"
    zeroed = padding_zeroer(MessageType("shoal_test/msg/Pairs", pairs, "RIHS01_0"))
    assert zeroed(bytes([0, 1, 0, 0]) + b"\xff" * 4 + bytes(60)) is None  # four thousand million pairs


@given(st.lists(st.tuples(st.integers(1, 9), st.integers(0, 2), st.integers(0, 3)), max_size=9))
def test_one_zeroer_serves_messages_of_all_shapes_in_any_order(shapes):
    zeroed = padding_zeroer(LAYOUT)
    for length, count, tail in shapes:
        clean = layout_message(length, count, 0)
        assert zeroed(layout_message(length, count, 0xA5) + b"\xa5" * tail) == clean


@pytest.mark.ros
def test_messages_of_the_graph_decode_to_the_same_after_zeroing():
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
    from rclpy.serialization import deserialize_message, serialize_message

    from auv_bag.definitions import load_message_type
    from auv_msgs.msg import NeighbourEstimate, NeighbourEstimates

    assert os.environ.get("AMENT_PREFIX_PATH")
    estimates = NeighbourEstimates(tick=7, neighbours=[NeighbourEstimate(address=k) for k in range(3)])
    status = DiagnosticStatus(name="a", message="bc", values=[KeyValue(key="k", value="xyz")])
    for message in (estimates, DiagnosticArray(status=[status, status])):
        name = f"{type(message).__module__.split('.')[0]}/msg/{type(message).__name__}"
        data = padding_zeroer(load_message_type(name))(serialize_message(message))
        assert deserialize_message(data, type(message)) == message
