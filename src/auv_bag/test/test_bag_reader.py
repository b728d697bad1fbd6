"""Reading bags: order, damage, and the errors that a user sees."""

from dataclasses import dataclass

import pytest
import synthetic_bag as synthetic
import yaml
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk
from mcap.writer import Writer

from auv_bag import mcap_scan
from auv_bag.bag import Bag
from auv_bag.compare import compare_bags
from auv_bag.writer import BagError, BagWriter, Topic

RELAXED = settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
TIMES = st.lists(st.tuples(st.sampled_from(["/a", "/b", "/c"]), st.integers(0, 2**62)), max_size=60)


def write_payloads(bag_dir, rows, chunk_bytes):
    """Write (topic, time) rows; the payload is the row's number."""
    bag_dir.parent.mkdir(exist_ok=True)
    writer = BagWriter(bag_dir, chunk_bytes=chunk_bytes)
    channels = {}
    for number, (topic, time_ns) in enumerate(rows):
        if topic not in channels:
            channels[topic] = writer.add_topic(Topic(topic, synthetic.message_type("nav_msgs/msg/Path")))
        writer.write(channels[topic], number.to_bytes(4, "little"), time_ns)
    return writer


def read_back(bag, **options):
    return [
        (each.topic, each.time_ns, int.from_bytes(each.data, "little")) for each in bag.messages(**options)
    ]


@RELAXED
@given(rows=TIMES, chunk_bytes=st.integers(1, 2000), start_ns=st.integers(0, 2**62), data=st.data())
def test_messages_come_by_time_and_equal_times_in_recorded_order(
    tmp_path_factory, rows, chunk_bytes, start_ns, data
):
    bag_dir = tmp_path_factory.mktemp("order") / "bag"
    write_payloads(bag_dir, rows, chunk_bytes).close()
    expected = sorted(((topic, t_ns, k) for k, (topic, t_ns) in enumerate(rows)), key=lambda row: row[1])
    bag = Bag(bag_dir)
    assert bag.complete
    assert read_back(bag) == expected
    topics = data.draw(st.sets(st.sampled_from(["/a", "/b", "/d"])))
    assert read_back(bag, topics=topics, start_ns=start_ns) == [
        row for row in expected if row[0] in topics and row[1] >= start_ns
    ]
    times_ns = [t_ns for _, t_ns in rows]
    assert bag.span_ns() == ((min(times_ns), max(times_ns)) if rows else (0, 0))


@dataclass(repr=False)
class Whole:
    rows: list
    content: bytes


@pytest.fixture(scope="module")
def whole_file(tmp_path_factory):
    bag_dir = tmp_path_factory.mktemp("whole") / "bag"
    rows = [("/a" if k % 3 else "/b", k * 1000) for k in range(400)]
    write_payloads(bag_dir, rows, 500).close()
    return Whole(rows, (bag_dir / "bag_0.mcap").read_bytes())


@RELAXED
@given(share=st.floats(0.0, 1.0))
def test_a_file_cut_anywhere_gives_a_beginning_of_the_recording(tmp_path_factory, whole_file, share):
    rows, content = whole_file.rows, whole_file.content
    path = tmp_path_factory.mktemp("cut") / "bag_0.mcap"
    path.write_bytes(content[: int(share * len(content))])
    try:
        bag = Bag(path.parent)
        read = read_back(bag)
    except BagError:
        assert share * len(content) < 100
    else:
        assert read == [(topic, t_ns, k) for k, (topic, t_ns) in enumerate(rows)][: len(read)]
        assert bag.complete == (share == 1.0) or len(read) == len(rows)


@RELAXED
@given(place=st.floats(0.0, 0.999), value=st.integers(0, 255))
def test_a_damaged_byte_gives_messages_or_one_error(tmp_path_factory, whole_file, place, value):
    damaged = bytearray(whole_file.content)
    damaged[int(place * len(damaged))] = value
    path = tmp_path_factory.mktemp("damaged") / "bag_0.mcap"
    path.write_bytes(damaged)
    said = ""
    try:
        bag = Bag(path)
        list(bag.messages())
    except BagError as error:
        said = str(error)
    assert "\n" not in said


def test_a_bag_is_found_by_its_folder_its_results_folder_and_its_file(tmp_path):
    write_payloads(tmp_path / "results" / "bag", [("/a", 1)], 100).close()
    for path in ("results", "results/bag", "results/bag/bag_0.mcap"):
        bag = Bag(tmp_path / path)
        assert bag.folder == tmp_path / "results" / "bag"
        assert read_back(bag) == [("/a", 1, 0)]


def test_files_of_a_split_bag_are_read_in_order(tmp_path):
    for k in (0, 1, 2, 10):
        write_payloads(tmp_path / f"part{k}", [("/a", k)], 100).close()
        (tmp_path / f"part{k}" / f"part{k}_0.mcap").rename(tmp_path / f"bag_{k}.mcap")
    assert [t_ns for _, t_ns, _ in read_back(Bag(tmp_path))] == [0, 1, 2, 10]


def test_an_unchunked_file_is_read_too(tmp_path):
    with (tmp_path / "x.mcap").open("wb") as file:
        writer = Writer(file, use_chunking=False)
        writer.start(profile="ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        channel = writer.register_channel("/a", "cdr", schema)
        writer.add_message(channel, 5, b"\0\1\0\0", 5)
        writer.finish()
    assert [(each.time_ns, each.type_name) for each in Bag(tmp_path).messages()] == [
        (5, "std_msgs/msg/String")
    ]


@pytest.mark.parametrize("stated_bytes", [100, 3_000_000])
def test_a_chunk_that_unpacks_to_too_much_is_refused_before_it_is(tmp_path, monkeypatch, stated_bytes):
    monkeypatch.setattr(mcap_scan, "MOST_CHUNK_BYTES", 1_000_000)
    write_payloads(tmp_path / "bag", [("/a", 5)], 10).close()
    chunk = Chunk(
        compression="zstd",
        data=zstandard.compress(bytes(3_000_000)),
        message_end_time=5,
        message_start_time=5,
        uncompressed_crc=0,
        uncompressed_size=stated_bytes,
    )
    insert(tmp_path / "bag" / "bag_0.mcap", chunk)
    with pytest.raises(BagError, match="unpacks to 3000000 bytes; allowed: at most 1000000"):
        list(Bag(tmp_path).messages())


def insert(path, chunk):
    """Put a chunk in front of all others."""
    content = path.read_bytes()
    builder = RecordBuilder()
    chunk.write(builder)
    place = 17 + int.from_bytes(content[9:17], "little")  # behind the header
    path.write_bytes(content[:place] + builder.end() + content[place:])


def test_a_chunk_without_messages_has_no_time(tmp_path):
    bag_dir = tmp_path / "bag"
    write_payloads(bag_dir, [("/a", 5_000), ("/b", 7_000), ("/a", 6_000)], 10).close()
    chunk = Chunk(
        compression="",
        data=b"",
        message_end_time=0,
        message_start_time=0,
        uncompressed_crc=0,
        uncompressed_size=0,
    )
    insert(bag_dir / "bag_0.mcap", chunk)
    bag = Bag(bag_dir)
    assert bag.span_ns() == (5_000, 7_000)
    assert [t_ns for _, t_ns, _ in read_back(bag)] == [5_000, 6_000, 7_000]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda folder: None, "no such folder"),
        (lambda folder: folder.mkdir(), "neither metadata.yaml nor an .mcap file"),
        (lambda folder: _file(folder, "metadata.yaml", b"[1"), "not the metadata of a bag"),
        (lambda folder: _file(folder, "metadata.yaml", b"\xff\xfe"), "not the metadata of a bag"),
        (lambda folder: _metadata(folder, "sqlite3", ["x.db3"]), "stored as sqlite3"),
        (lambda folder: _metadata(folder, "mcap", ["gone.mcap"]), "lacks gone.mcap"),
        (lambda folder: _metadata(folder, "mcap", []), "lacks its .mcap file"),
        (lambda folder: _file(folder, "x.mcap", b""), "is empty"),
        (lambda folder: _file(folder, "x.mcap", b"hello, world"), "is not an MCAP file"),
    ],
)
def test_what_is_no_bag_gives_one_clear_line(tmp_path, make, said):
    make(tmp_path / "bag")
    with pytest.raises(BagError) as caught:
        Bag(tmp_path / "bag")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def _file(folder, name, content):
    folder.mkdir()
    (folder / name).write_bytes(content)


def _metadata(folder, storage, files):
    information = {"storage_identifier": storage, "relative_file_paths": files}
    _file(folder, "metadata.yaml", yaml.safe_dump({"rosbag2_bagfile_information": information}).encode())


def record(bag_dir, rows):
    """Write a bag of (topic, time, text) rows of log-like messages."""
    recorder = synthetic.Recorder(bag_dir)
    for topic, time_ns, text in rows:
        header = synthetic.header(time_ns, text)
        recorder.write(topic, synthetic.make("nav_msgs/msg/Path", header=header, poses=[]), time_ns)
    recorder.writer.close()
    return bag_dir


SAME = [
    ("/a", 0, "x"),
    ("/tf", 0, "one"),
    ("/tf", 0, "two"),
    ("/a", 1, "y"),
    ("/tf", 1, "one"),
    ("/rosout", 1, "p"),
]


def test_bags_of_the_same_run_are_the_same(tmp_path):
    other = [SAME[2], SAME[0], SAME[1], SAME[4], SAME[3], ("/rosout", 7, "q"), ("/recorder/status", 1, "z")]
    assert compare_bags(record(tmp_path / "a", SAME), record(tmp_path / "b", other)) == []


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([*SAME, ("/b", 1, "new")], "/b: 0 messages against 1"),
        (SAME[:3] + SAME[4:], "/a: 2 messages against 1"),
        ([*SAME[:3], ("/a", 1, "z"), *SAME[4:]], "/a: message 1 at 0.000 s differs from byte 16 on"),
        ([*SAME[:4], ("/tf", 1, "two"), *SAME[5:]], "/tf: message 2 at 0.000 s differs"),
        ([SAME[3], *SAME[1:3], SAME[0], *SAME[4:]], None),
    ],
)
def test_a_difference_is_named(tmp_path, rows, said):
    differences = compare_bags(record(tmp_path / "a", SAME), record(tmp_path / "b", rows))
    if said is None:  # written in another order, but of the same times: read in the same order
        assert differences == []
    else:
        assert len(differences) == 1
        assert differences[0].startswith(said)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"[1, 2]", "it has no rosbag2_bagfile_information"),
        (b"", "it has no rosbag2_bagfile_information"),
        (b"rosbag2_bagfile_information: 5", "it has no rosbag2_bagfile_information"),
        (b"rosbag2_bagfile_information: {}", "it names no storage"),
        (
            b"rosbag2_bagfile_information: {storage_identifier: mcap, relative_file_paths: 5}",
            "its relative_file_paths is not a list",
        ),
        (b"a: [", "it is not YAML"),
        (b"? {a: 1}\n: 2", "it is not YAML"),
        (b"a: 2026-99-99", "it is not YAML"),
        (b"\xff\xfe\xfa", "it is not UTF-8 text"),
        (b"[" * 21 + b"]" * 21, "it has aliases, or is nested more than 20 deep"),
        (b"a: &b [1]\nc: *b", "it has aliases, or is nested more than 20 deep"),
    ],
)
def test_what_is_wrong_with_a_metadata_file_is_said_in_words(tmp_path, content, reason):
    write_payloads(tmp_path / "bag", [("/a", 1)], 100).close()
    metadata = tmp_path / "bag" / "metadata.yaml"
    metadata.write_bytes(content)
    (note,) = Bag(tmp_path / "bag").notes
    assert note == f"{metadata} is damaged ({reason}); the .mcap files beside it are read"
