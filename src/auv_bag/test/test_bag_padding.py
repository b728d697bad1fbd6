"""Padding bytes: equal messages have equal bytes in the bag."""

import numpy as np
import pytest
import synthetic_bag as synthetic
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_bag.padding import padding_zeroer
from auv_bag.topics import topics_of_graph

TYPES = sorted({spec.type_name for spec in topics_of_graph(["a"], ["wrench"], lockstep=True)})


def serialised(message):
    return bytes(synthetic.typestore().serialize_cdr(message, message.__msgtype__))


def padding_of(data, name):
    """Find the padding of a message by trial: the bytes that can change without the message changing."""
    places = []
    for place in range(4, len(data)):
        if all(decodes_alike(data, place, flipped, name) for flipped in (0x01, 0x14)):
            places.append(place)
    return places


def decodes_alike(data, place, flipped, name):
    store = synthetic.typestore()
    changed = bytearray(data)
    changed[place] ^= flipped
    try:
        return serialised(store.deserialize_cdr(bytes(changed), name)) == data
    except Exception:
        return False  # a length was changed


@pytest.mark.parametrize("name", TYPES)
def test_what_lies_between_the_fields_is_cleared_and_nothing_else(name):
    clean = padding_zeroer(synthetic.message_type(name))
    rng = np.random.default_rng(5)
    found = 0
    for _ in range(3):
        data = serialised(synthetic.random_message(name, rng))
        assert clean(data) == data
        dirty = bytearray(data)
        for place in padding_of(data, name):
            dirty[place] = 0xA5
            found += 1
        assert clean(bytes(dirty)) == data
    assert found > 0 or name in ("rosgraph_msgs/msg/Clock", "std_msgs/msg/String")


@settings(max_examples=100, deadline=None)
@given(name=st.sampled_from(TYPES), seed=st.integers(0, 2**32))
def test_a_clean_message_is_not_touched(name, seed):
    data = serialised(synthetic.random_message(name, np.random.default_rng(seed)))
    assert padding_zeroer(synthetic.message_type(name))(data) == data


@given(st.sampled_from(TYPES), st.binary(max_size=40))
def test_bytes_that_are_no_message_do_no_harm(name, data):
    clean = padding_zeroer(synthetic.message_type(name))
    found = clean(data)
    assert found is None or 0 <= len(data) - len(found) < 4
    assert clean(b"\0\0" + data) is None
