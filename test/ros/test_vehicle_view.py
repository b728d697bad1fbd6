"""Topics of a vehicle node for people and tools: at which ticks, and whether truth or estimate."""

from types import SimpleNamespace
from typing import Any

import pytest

pytestmark = pytest.mark.ros

N_TICKS = 10
NOISY = "environment.navigation={kind: noisy, params: {position_sd_m: 2.0, velocity_sd_mps: 0.5}}"


class Publisher(list):
    """Keeps what is published, message or bytes."""

    handle = property(lambda self: SimpleNamespace(publish_raw=self.append))
    publish = list.append


@pytest.fixture
def flown():
    """Fly a vehicle with noise, without a valid navigation in tick 3; return states, navs and messages."""
    from rclpy.serialization import deserialize_message

    from auv_experiment.compose import vehicle_configs
    from auv_experiment.scenario.loading import load_scenario
    from auv_ros.topic import Topics
    from auv_sim.nodes.vehicle_view import VehicleView
    from auv_sim.vehicle import Vehicle

    config = vehicle_configs(load_scenario("flock_acoustic", overrides=[NOISY]))[0]
    vehicle = Vehicle(config)
    topics: dict[str, Any] = {}
    kinds: dict[str, Any] = {}

    def create_publisher(kind, topic, _qos):
        kinds[topic] = kind
        return topics.setdefault(topic, Publisher())

    node = SimpleNamespace(create_publisher=create_publisher)
    view = VehicleView(Topics(node), config, vehicle.navigation.velocity_sd_mps)
    states, navs = [], []
    for tick in range(N_TICKS):
        if tick == 3:
            vehicle.nav = vehicle.nav._replace(is_valid=False)
        view.publish(1.0 + 0.1 * tick, vehicle)
        states.append(vehicle.state)
        navs.append(vehicle.nav)
        vehicle.step(None)
    heard = {
        topic: [deserialize_message(each, kinds[topic]) if isinstance(each, bytes) else each for each in sent]
        for topic, sent in topics.items()
    }
    return states, navs, heard


def test_odometry_is_the_estimate_of_every_tick_with_a_valid_one(flown):
    states, navs, heard = flown
    valid = [k for k in range(N_TICKS) if k != 3]
    places = [message.pose.pose.position for message in heard["odom"]]
    assert [place.x for place in places] == [navs[k].position[1] for k in valid]
    assert places[0].x != states[0].position[1]
    for message in heard["odom"]:
        assert message.pose.covariance[[0, 7, 14]].tolist() == [4.0, 4.0, 4.0]
        assert message.twist.covariance[[0, 7, 14]].tolist() == [0.25, 0.25, 0.25]


def test_the_frames_come_at_every_tick(flown):
    states, navs, heard = flown
    assert len(heard["/tf"]) == N_TICKS
    for message, state, nav in zip(heard["/tf"], states, navs, strict=True):
        _, believed, true = message.transforms
        assert believed.transform.translation.y == nav.position[0]
        assert true.transform.translation.y == state.position[0]


def test_the_truth_comes_at_every_fifth_tick(flown):
    states, _, heard = flown
    places = [message.pose.pose.position for message in heard["ground_truth/odom"]]
    assert [-place.z for place in places] == [states[0].position[2], states[5].position[2]]
    assert len(heard["/markers"]) == 2


def test_what_stands_is_published_once(flown):
    _, _, heard = flown
    assert len(heard["/tf_static"]) == len(heard["robot_description"]) == 1
