"""Messages read as columns equal the messages read one by one."""

import numpy as np
import pytest
import synthetic_bag as synthetic
from numpy.testing import assert_array_equal

from auv_bag.bag import Bag
from auv_bag.columns import Columns
from auv_bag.topics import topics_of_graph
from auv_bag.writer import BagError, BagWriter, Topic
from auv_core.messages import COMMANDS

TYPES = sorted(
    {spec.type_name for command in COMMANDS for spec in topics_of_graph(["auv_1"], [command], lockstep=False)}
)
CHANGES = 60


def serialised(message, *, little_endian=True):
    store, name = synthetic.typestore(), message.__msgtype__
    return bytes(store.serialize_cdr(message, name, little_endian=little_endian))


def changed(data, rng):
    """Return a message with another byte, cut off, or with more behind its end."""
    changed_data = bytearray(data)
    kind, place = rng.integers(4), rng.integers(len(data))
    if kind == 0:
        return bytes(data[:place])
    if kind == 1:
        return bytes(data) + bytes(rng.integers(0, 256, rng.integers(1, 9), np.uint8))
    changed_data[place if kind == 2 else rng.integers(min(len(data), 40))] = rng.integers(0, 256)
    return bytes(changed_data)


def written(folder, type_name, messages):
    """Write a bag of messages of one type to two topics in turn."""
    writer = BagWriter(folder / "bag", chunk_bytes=4000)
    channels = [writer.add_topic(Topic(name, synthetic.message_type(type_name))) for name in ("/a", "/b")]
    for k, data in enumerate(messages):
        writer.write(channels[k % 2], data, k)
    writer.close()
    return Bag(folder / "bag")


def assert_same(columns, k, message):
    if isinstance(columns, Columns):
        for name, _ in synthetic.typestore().get_msgdef(message.__msgtype__).fields:
            assert_same(getattr(columns, name), k, getattr(message, name))
    elif isinstance(columns, list):
        for each, other in zip(columns, message, strict=True):
            assert_same(each, k, other)
    else:
        assert_array_equal(columns[k] if isinstance(columns, np.ndarray) else columns, message)


@pytest.mark.parametrize("type_name", TYPES)
def test_columns_hold_what_messages_hold_and_leave_out_what_cannot_be_decoded(tmp_path, type_name):
    rng = np.random.default_rng(len(type_name))
    messages = [synthetic.random_message(type_name, rng) for _ in range(6)]
    data = [serialised(each, little_endian=k % 3 > 0) for k, each in enumerate(messages)] * 4
    data += [changed(data[rng.integers(len(data))], rng) for _ in range(CHANGES)]
    bag = written(tmp_path, type_name, [data[k] for k in rng.permutation(len(data))])
    expected, n_malformed = {}, 0
    for place, message in enumerate(bag.messages()):
        try:
            expected[message.time_ns, place] = message.topic, bag.decode(message)
        except BagError:
            n_malformed += 1
    n_columns = n_all = 0
    for topic, batches, count in bag.columns({"/a", "/b"}):
        n_all += count
        for batch in batches:
            n_columns += len(batch.messages)
            for k, key in enumerate(map(tuple, batch.order.tolist())):
                expected_topic, message = expected.pop(key)
                assert topic == expected_topic
                assert_same(batch.messages, k, message)
    assert (expected, n_all - n_columns) == ({}, n_malformed)
    assert n_columns > 24


def test_messages_that_flags_choose_are_those(tmp_path):
    rng = np.random.default_rng(1)
    message = synthetic.random_message("auv_msgs/msg/VehicleState", rng)
    data = []
    for tick in range(10):
        message.tick = tick
        data.append(serialised(message))
    bag = written(tmp_path, "auv_msgs/msg/VehicleState", data)
    ((_, batches, _),) = bag.columns({"/b"})
    (batch,) = batches
    chosen = batch.only(batch.messages.tick > 4)
    assert_array_equal(chosen.messages.tick, [5, 7, 9])
    assert_array_equal(chosen.order[:, 0], [5, 7, 9])
    assert not hasattr(chosen.messages, "no_such_field")


def test_many_messages_of_as_many_shapes_are_read(tmp_path):
    message = synthetic.random_message("auv_msgs/msg/ControlStatus", np.random.default_rng(1))
    names = [f"{number:05}" for number in range(300)]
    data = []
    for message.holding in names:
        data.append(serialised(message))
    bag = written(tmp_path, "auv_msgs/msg/ControlStatus", data)
    found = [batch.messages.holding for _, batches, _ in bag.columns({"/a", "/b"}) for batch in batches]
    assert sorted(found) == names
