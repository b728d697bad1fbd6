"""Claim: a topic publishes what its writer makes, and knows who must hear it."""

from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from auv_ros.topic import RECORDER, Topic, Topics

pytestmark = pytest.mark.ros


@pytest.fixture
def sent():
    """Return what was published, as (topic, how, what)."""
    return []


@pytest.fixture
def node(sent):
    """Return a node whose publishers keep what they publish."""

    def create_publisher(_kind, name, _qos):
        return SimpleNamespace(
            publish=lambda message: sent.append((name, "object", message)),
            handle=SimpleNamespace(publish_raw=lambda data: sent.append((name, "bytes", data))),
        )

    return SimpleNamespace(create_publisher=create_publisher)


def test_what_the_writer_makes_is_published_as_bytes(node, sent):
    topic = Topic(node, None, "state", lambda t_s, *numbers: f"{t_s} {numbers}".encode())
    topic.publish(1.5, 2, 3)
    topic.publish_bytes(b"ready")
    assert sent == [("state", "bytes", b"1.5 (2, 3)"), ("state", "bytes", b"ready")]


def test_without_a_writer_message_objects_are_published(node, sent):
    Topic(node, None, "path").publish("a message")
    assert sent == [("path", "object", "a message")]


@pytest.mark.parametrize(
    ("is_recorded", "waits", "heard_by"),
    [
        (False, False, set()),
        (False, True, {"/auv_1/agent_node"}),
        (True, False, {RECORDER}),
        (True, True, {RECORDER, "/auv_1/agent_node"}),
    ],
)
def test_a_recorder_must_hear_every_topic_and_others_theirs(node, is_recorded, waits, heard_by):
    topics = Topics(node, is_recorded=is_recorded, waits=waits)
    nav = topics.add(None, "nav", heard_by=["/auv_1/agent_node"])
    marker = topics.add(None, "/markers")
    assert list(topics) == [nav, marker]
    assert nav.heard_by == heard_by
    assert marker.heard_by == heard_by - {"/auv_1/agent_node"}
