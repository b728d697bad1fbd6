"""The process that writes a bag, used without ROS."""

import os
import signal
import time
from multiprocessing.connection import Pipe

import pytest

from auv_bag.bag import Bag
from auv_bag.link import BagLink, Batch, Opening, Written
from auv_bag.process import serve
from auv_bag.topic_spec import TopicSpec
from auv_bag.writer import BagError


def test_a_bag_is_open_before_the_first_message_and_closed_when_told_to(tmp_path):
    link = BagLink(Opening(tmp_path / "bag", (), lockstep=True))
    link.wait_until_open()
    assert not Bag(tmp_path).complete
    link.write(Batch({}, is_checkpoint=True))
    link.close()
    assert link.written.closed
    assert Bag(tmp_path).complete


@pytest.mark.parametrize(
    ("topics", "words"),
    [
        ((), "exists already; a bag is never overwritten"),
        ([TopicSpec("/a", "no_msgs/msg/Word")], "no Word.msg of package no_msgs"),
    ],
)
def test_what_cannot_be_recorded_is_refused_in_the_words_of_its_error(tmp_path, topics, words):
    if not topics:
        (tmp_path / "bag").mkdir()
    with pytest.raises(BagError, match=words) as refused:
        BagLink(Opening(tmp_path / "bag", tuple(topics), lockstep=True)).wait_until_open()
    assert "\n" not in str(refused.value)


def test_the_end_of_the_line_closes_the_bag(tmp_path):
    ours, theirs = Pipe()
    ours.send(Opening(tmp_path / "bag", (), lockstep=True))
    ours.send(Batch({}))
    ours.close()
    serve(theirs)
    assert Bag(tmp_path).complete


def test_answers_count_what_is_written_and_the_last_says_that_the_bag_is_closed(tmp_path):
    ours, theirs = Pipe()
    for word in (Opening(tmp_path / "bag", (), lockstep=True), Batch({}), None):
        ours.send(word)
    serve(theirs)
    first, second, last = (ours.recv() for _ in range(3))
    assert first == second == Written(bytes=first.bytes)
    assert last == Written(bytes=(tmp_path / "bag" / "bag_0.mcap").stat().st_size, closed=True)


@pytest.mark.parametrize("size", [0, 2_000_000])
def test_a_stopped_process_is_ended_whether_it_is_sent_more_or_waited_for(tmp_path, size):
    topic = TopicSpec("/flock/status", "auv_msgs/msg/FlockStatus")
    link = BagLink(Opening(tmp_path / "bag", (topic,), lockstep=True))
    link.wait_until_open()

    def write_and_close():
        link.write(Batch({topic.name: [bytes(size)]}))
        link.close()

    os.kill(link._process.pid, signal.SIGSTOP)
    start_s = time.monotonic()
    with pytest.raises(BagError, match="a signal had stopped it for 3 s"):
        write_and_close()
    assert time.monotonic() - start_s < 6.0
    assert link._process.poll() == -signal.SIGKILL
