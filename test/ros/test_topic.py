"""The topic command as a process, beside a real graph."""

import signal

import pytest
import yaml

pytest.importorskip("rclpy")

from ros_desk import desk, finish, process

from auv_msgs.msg import AcousticInbox, AcousticPacket, AcousticReception

pytestmark = pytest.mark.ros

TOPIC = "auv_bringup.tools.topic"
NAME = "/auv_1/acoustic/rx"


@pytest.fixture
def graph():
    with desk() as at:
        at.inbox = at.publisher(AcousticInbox, NAME)
        at.other = at.publisher(AcousticInbox, "/auv_2/acoustic/rx")
        at.tick = 0
        yield at


def publish(at):
    packet = AcousticPacket(tick=at.tick, source=2, sequence=7, payload=list(range(200)))
    inbox = AcousticInbox(tick=at.tick, receptions=[AcousticReception(packet=packet, snr_db=float("nan"))])
    inbox.header.stamp.sec = at.tick
    at.inbox.publish(inbox)
    at.tick += 1


def publish_until_it_ends(at, child):
    """Publish about 50 messages a second until the command has ended."""

    def has_ended():
        publish(at)
        return child.poll() is not None

    at.until(has_ended, "the command ends")
    return finish(child, None)


def test_list_shows_names_and_types(graph):
    with process(TOPIC, "list") as command:
        status, out, errors = finish(command, None)
    assert (status, errors) == (0, "")
    assert {NAME, "/auv_2/acoustic/rx"} <= set(out.splitlines())
    with process(TOPIC, "list", "-t") as command:
        assert f"{NAME} [auv_msgs/msg/AcousticInbox]" in finish(command, None)[1].splitlines()


def test_echo_prints_messages_as_yaml(graph):
    with process(TOPIC, "echo", NAME, "-n", 2) as command:
        status, out, errors = publish_until_it_ends(graph, command)
    assert (status, errors) == (0, "")
    first, second = [yaml.safe_load(each) for each in out.split("---\n")[:2]]
    assert second["tick"] == first["tick"] + 1 == second["header"]["stamp"]["sec"]
    payload = first["receptions"][0]["packet"]["payload"]
    assert payload == [*range(128), "..."]
    assert first["receptions"][0]["snr_db"] != first["receptions"][0]["snr_db"]


def test_hz_prints_the_rate_until_interrupted(graph):
    with process(TOPIC, "hz", NAME, "--window", 50) as command:
        for _ in range(2):
            line: list[str] = []

            def heard(line=line):
                publish(graph)
                return command.poll() is not None or len(graph_rates(command, line)) > 0

            graph.until(heard, "a rate")
        status, _, errors = finish(command, signal.SIGINT)
    assert (status, errors) == (130, "")


def graph_rates(command, line):
    """Read what the command has printed, without waiting."""
    import select

    if select.select([command.stdout], [], [], 0.0)[0]:
        line.append(command.stdout.readline())
    return [each for each in line if each.startswith("average rate: ")]


def test_info_counts_and_names_the_endpoints(graph):
    with process(TOPIC, "info", NAME) as command:
        status, out, errors = finish(command, None)
    assert (status, errors) == (0, "")
    assert out == "Type: auv_msgs/msg/AcousticInbox\nPublisher count: 1\nSubscription count: 0\n"
    with process(TOPIC, "info", NAME, "--verbose") as command:
        out = finish(command, None)[1]
    assert "Node name: desk" in out
    assert "Reliability: RELIABLE" in out
    assert "RIHS01_" in out


@pytest.mark.parametrize(
    ("name", "said"),
    [("/auv_1/acoustic/tx", f"did you mean {NAME}"), ("/zzz", "`./scripts/topic list` shows all topics")],
)
def test_an_unknown_topic_gives_a_hint(graph, name, said):
    with process(TOPIC, "--wait", 1, "echo", name) as command:
        status, _, errors = finish(command, None)
    assert status == 2
    assert f"no topic {name} in ROS domain" in errors
    assert said in errors
    assert errors.count("\n") == 1


def test_echo_of_a_silent_topic_ends(graph):
    with process(TOPIC, "--silence", 0.5, "echo", NAME, "--once") as command:
        status, out, errors = finish(command, None)
    assert (status, out) == (2, "")
    assert f"error: no message of {NAME} for " in errors
