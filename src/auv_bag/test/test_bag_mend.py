"""A bag whose writer was killed is repaired, so that standard readers can read it."""

import shutil
from pathlib import Path

import pytest
import synthetic_bag as synthetic
import yaml
from full_disk import files_of_at_most
from mcap.opcode import Opcode
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from auv_bag.bag import Bag
from auv_bag.mcap_scan import MAGIC, records_of
from auv_bag.mend import mend_bag
from auv_bag.writer import BagWriter, Qos, Topic

TOPICS = ("/a", "/b", "/c")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return a folder with a bag of many small chunks."""
    bag_dir = tmp_path_factory.mktemp("whole") / "bag"
    write(bag_dir).close()
    return bag_dir


def write(bag_dir, count=400):
    """Write some messages; the last chunk is still open."""
    writer = BagWriter(bag_dir, chunk_bytes=1000)
    kind = synthetic.message_type("nav_msgs/msg/Path")
    offered = (Qos(), Qos(durability="transient_local", depth=3))
    channels = [writer.add_topic(Topic(name, kind, offered)) for name in TOPICS]
    for k in range(count):
        writer.write(channels[k % 3], k.to_bytes(4, "little") * 20, 1_000 + 10 * k)
    return writer


def cut(whole, folder, size):
    """Copy a bag with the file cut to a size, and the metadata of an early checkpoint."""
    shutil.copytree(whole, folder)
    path = folder / "bag_0.mcap"
    path.write_bytes(path.read_bytes()[:size])
    (folder / "metadata.yaml").write_text("")
    return path


def contents(bag_dir):
    return [(each.topic, each.time_ns, each.data) for each in Bag(bag_dir).messages()]


def read_by_others(bag_dir):
    """Return what rosbags and the mcap library read."""
    with Reader(bag_dir) as reader:
        by_rosbags = [(connection.topic, time, bytes(data)) for connection, time, data in reader.messages()]
        assert reader.message_count == len(by_rosbags)
    with (bag_dir / "bag_0.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        by_mcap = [(channel.topic, each.log_time, each.data) for _, channel, each in reader.iter_messages()]
        assert reader.get_summary().statistics.message_count == len(by_mcap)
        assert [name.name for name in reader.iter_metadata()][-1] == "rosbag2"
    return by_rosbags, by_mcap


@pytest.mark.parametrize("share", [0.03, 0.2, 0.5, 0.77, 0.9, 0.97, 0.999, 1.0 - 1e-9])
def test_a_file_cut_anywhere_is_readable_by_every_reader_and_loses_nothing_more(whole, tmp_path, share):
    size = (whole / "bag_0.mcap").stat().st_size
    path = cut(whole, tmp_path / "bag", int(share * size))
    before = contents(path)
    assert "the file is repaired" in mend_bag(tmp_path)[0]
    bag = Bag(tmp_path)
    assert bag.complete
    assert bag.notes == ()
    assert contents(tmp_path) == before
    if share > 0.1:  # before that there is not even one channel
        assert before
        by_rosbags, by_mcap = read_by_others(tmp_path / "bag")
        assert by_rosbags == by_mcap == before
    assert mend_bag(tmp_path) == ()


@pytest.mark.parametrize("indexes", [0, 1, 2, 3])
def test_a_file_cut_between_a_chunk_and_its_message_indexes_loses_nothing(whole, tmp_path, indexes):
    data = (whole / "bag_0.mcap").read_bytes()
    ends = [stop for opcode, _, stop in records_of(data, len(MAGIC), len(data)) if opcode == Opcode.CHUNK]
    after = records_of(data, ends[20], len(data))
    stops = [ends[20], *(stop for _, (_, _, stop) in zip(range(indexes), after, strict=False))]
    path = cut(whole, tmp_path / "bag", stops[-1] + 5)
    before = contents(path)
    mend_bag(tmp_path)
    by_rosbags, by_mcap = read_by_others(tmp_path / "bag")
    assert by_rosbags == by_mcap == before == contents(tmp_path)


def test_the_metadata_is_that_of_a_bag_that_was_closed(whole, tmp_path):
    data = (whole / "bag_0.mcap").read_bytes()
    cut(whole, tmp_path / "bag", data.rindex(b"rosbag2") - 20)  # the second metadata record goes with the end
    mend_bag(tmp_path / "bag")
    assert (tmp_path / "bag" / "metadata.yaml").read_text() == (whole / "metadata.yaml").read_text()


def test_a_killed_writer_and_nul_bytes_after_a_power_cut_are_repaired(tmp_path):
    write(tmp_path / "bag")._file.close()
    with (tmp_path / "bag" / "bag_0.mcap").open("ab") as file:
        file.write(bytes(5000))
    before = contents(tmp_path)
    assert "is repaired" in mend_bag(tmp_path)[0]
    assert read_by_others(tmp_path / "bag") == (before, before)


def test_a_bag_that_is_still_written_is_left_alone(tmp_path):
    writer = write(tmp_path / "bag")
    size = (tmp_path / "bag" / "bag_0.mcap").stat().st_size
    assert "is still being written" in mend_bag(tmp_path)[0]
    assert (tmp_path / "bag" / "bag_0.mcap").stat().st_size == size
    writer.close()
    assert mend_bag(tmp_path) == ()


def test_a_mending_that_the_disk_does_not_take_is_said_and_done_later(whole, tmp_path):
    path = cut(whole, tmp_path / "bag", (whole / "bag_0.mcap").stat().st_size // 2)
    before = contents(path)
    with files_of_at_most(1000):
        (line,) = [each for each in mend_bag(tmp_path) if "repaired" in each]
    assert "it cannot be repaired (File too large), but read" in line
    assert contents(path) == before
    assert "is repaired" in mend_bag(tmp_path)[0]
    assert read_by_others(tmp_path / "bag") == (before, before)


def test_on_a_full_disk_a_file_gets_an_end_without_a_summary(whole, tmp_path):
    path = cut(whole, tmp_path / "bag", (whole / "bag_0.mcap").stat().st_size // 2)
    (tmp_path / "bag" / "metadata.yaml").write_text((whole / "metadata.yaml").read_text())
    before = contents(path)
    with files_of_at_most(path.stat().st_size + 60):  # less than any file system has to spare
        assert "is repaired" in mend_bag(tmp_path)[0]
    assert Bag(tmp_path).complete
    assert contents(path) == before
    with Reader(tmp_path / "bag") as reader:
        assert len(list(reader.messages())) == len(before)
    with path.open("rb") as file:
        assert len(list(make_reader(file).iter_messages())) == len(before)
    assert {each.name for each in (tmp_path / "bag").iterdir()} == {"bag_0.mcap", "metadata.yaml"}


def spoil_storage(text):
    information = yaml.safe_load(text)
    information["rosbag2_bagfile_information"]["storage_identifier"] = ""
    return yaml.safe_dump(information)


@pytest.mark.parametrize(
    "spoil",
    [
        spoil_storage,
        lambda text: "",
        lambda text: "\0" * len(text),
        lambda text: text[: len(text) // 2],
        lambda text: "a: &a [1, 2]\nb: *a\n" + text,
        lambda text: "[" * 100_000,
        lambda text: "!!int ''",
        lambda text: "#" * 9_000_000,
    ],
)
def test_broken_metadata_beside_a_whole_file_is_a_note(whole, tmp_path, spoil):
    folder = Path(shutil.copytree(whole, tmp_path / "bag"))
    (folder / "metadata.yaml").write_text(spoil((whole / "metadata.yaml").read_text()))
    bag = Bag(folder)
    assert contents(folder) == contents(whole)
    assert len(bag.notes) == 1
    assert "metadata.yaml is damaged" in bag.notes[0]
    assert mend_bag(folder) == bag.notes
