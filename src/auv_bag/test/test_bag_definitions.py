"""Message definitions, hashes and stamp positions."""

import json

import pytest
import synthetic_bag as synthetic
from hypothesis import given
from hypothesis import strategies as st

from auv_bag.definitions import (
    SEPARATOR,
    DefinitionError,
    full_definition,
    load_message_type,
    read_stamp_ns,
    share_folders,
    stamp_offset,
)

TEXTS = {
    "zoo_msgs/msg/Cage": "# a cage\nstd_msgs/Header header\nAnimal[] animals  # inside\nbool OPEN=1\n",
    "zoo_msgs/Animal": "string<=10 name\nuint8[4] feet\nzoo_msgs/Tail tail\n",
    "zoo_msgs/Tail": "float64 length\n",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
}


def test_a_definition_is_followed_by_each_used_type_once_depth_first_in_alphabetical_order():
    line = f"\n{SEPARATOR}\nMSG: "
    assert full_definition("zoo_msgs/msg/Cage", TEXTS.__getitem__) == (
        TEXTS["zoo_msgs/msg/Cage"]
        + line
        + "std_msgs/Header\n"
        + TEXTS["std_msgs/Header"]
        + line
        + "builtin_interfaces/Time\n"
        + TEXTS["builtin_interfaces/Time"]
        + line
        + "zoo_msgs/Animal\n"
        + TEXTS["zoo_msgs/Animal"]
        + line
        + "zoo_msgs/Tail\n"
        + TEXTS["zoo_msgs/Tail"]
    )


@pytest.mark.parametrize(
    ("name", "offset"),
    [
        ("auv_msgs/msg/VehicleState", 4),
        ("auv_msgs/msg/AcousticInbox", 4),
        ("auv_msgs/msg/FlockStatus", 4),
        ("nav_msgs/msg/Odometry", 4),
        ("nav_msgs/msg/Path", 4),
        ("rosgraph_msgs/msg/Clock", 4),
        ("rcl_interfaces/msg/Log", 4),
        ("tf2_msgs/msg/TFMessage", 8),
        ("visualization_msgs/msg/MarkerArray", 8),
        ("auv_msgs/msg/AcousticPacket", None),
        ("std_msgs/msg/String", None),
        ("std_msgs/msg/Float64MultiArray", None),
    ],
)
def test_where_the_stamp_of_a_message_is(name, offset):
    assert stamp_offset(synthetic.message_type(name).definition) == offset


def test_a_stamp_after_another_field_is_not_taken_for_the_first():
    assert stamp_offset("int32 count 5\nstd_msgs/Header header\n") is None
    assert stamp_offset("int32 MANY=5\nstd_msgs/Header header\n") == 4
    assert stamp_offset("# only constants\nint32 MANY=5\n") is None


@given(st.integers(0, 2**31 - 1), st.integers(0, 999_999_999), st.text("abc/_", max_size=9))
def test_the_stamp_read_from_the_bytes_is_the_one_in_the_message(sec, nanosec, frame_id):
    t_ns = sec * 10**9 + nanosec
    store = synthetic.typestore()
    path = synthetic.make("nav_msgs/msg/Path", header=synthetic.header(t_ns, frame_id), poses=[])
    transform = synthetic.make(
        "geometry_msgs/msg/TransformStamped",
        header=synthetic.header(t_ns, frame_id),
        child_frame_id="x",
        transform=synthetic.make(
            "geometry_msgs/msg/Transform",
            translation=synthetic.vector((0, 0, 0)),
            rotation=synthetic.pose((0, 0, 0), (1, 0, 0, 0)).orientation,
        ),
    )
    tree = synthetic.make("tf2_msgs/msg/TFMessage", transforms=[transform])
    assert read_stamp_ns(bytes(store.serialize_cdr(path, path.__msgtype__)), 4) == t_ns
    assert read_stamp_ns(bytes(store.serialize_cdr(tree, tree.__msgtype__)), 8) == t_ns


def test_an_empty_sequence_has_no_stamp():
    message = synthetic.make("tf2_msgs/msg/TFMessage", transforms=[])
    data = bytes(synthetic.typestore().serialize_cdr(message, message.__msgtype__))
    assert read_stamp_ns(data, 8) is None


def test_a_type_is_read_from_the_share_folders(tmp_path):
    for name, text in TEXTS.items():
        package, type_name = name.split("/")[0], name.split("/")[-1]
        folder = tmp_path / package / "msg"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{type_name}.msg").write_text(text)
    hashes = [{"type_name": "zoo_msgs/msg/Cage", "hash_string": "RIHS01_00"}]
    (tmp_path / "zoo_msgs" / "msg" / "Cage.json").write_text(json.dumps({"type_hashes": hashes}))
    found = load_message_type("zoo_msgs/msg/Cage", [tmp_path / "elsewhere", tmp_path])
    assert found.type_hash == "RIHS01_00"
    assert found.definition.count(SEPARATOR) == 4
    with pytest.raises(DefinitionError, match=r"no Ghost\.msg of package zoo_msgs"):
        load_message_type("zoo_msgs/msg/Ghost", [tmp_path])
    with pytest.raises(DefinitionError, match=r"no Tail\.json"):
        load_message_type("zoo_msgs/msg/Tail", [tmp_path])


def test_share_folders_come_from_the_prefix_path():
    folders = share_folders({"AMENT_PREFIX_PATH": "/ws/a:/ws/b:"})
    assert [str(folder) for folder in folders] == ["/ws/a/share", "/ws/b/share"]
    assert share_folders({}) == []
