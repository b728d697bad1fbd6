"""Claims about what a recorder takes at once."""

from auv_bag.collector import TICKS_PER_BATCH, Collector
from auv_bag.topics import CLOCK_TOPIC


def test_a_batch_has_the_ticks_that_were_heard_before_those_that_wait():
    waiting = {"/said": [], CLOCK_TOPIC: [b"3"], "/auv_1/state": [b"a", b"b"]}
    collector = Collector({topic: messages.copy for topic, messages in waiting.items()})
    assert not collector.hear_tick(b"1")
    assert not collector.hear_tick(b"2")
    assert collector.topics_met == set()
    batch = collector.batch()
    assert list(batch.messages.items()) == [(CLOCK_TOPIC, [b"1", b"2", b"3"]), ("/auv_1/state", [b"a", b"b"])]
    assert not batch.is_checkpoint
    assert collector.topics_met == {CLOCK_TOPIC, "/auv_1/state"}
    assert collector.batch(is_checkpoint=True).messages[CLOCK_TOPIC] == [b"3"]


def test_a_batch_is_due_after_some_ticks():
    collector = Collector({CLOCK_TOPIC: list})
    due = [collector.hear_tick(b"tick") for _ in range(TICKS_PER_BATCH)]
    assert due == [False] * (TICKS_PER_BATCH - 1) + [True]
    collector.batch()
    assert not collector.hear_tick(b"tick")
