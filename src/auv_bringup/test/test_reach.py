"""A run is reached from this machine only, unless the user lets others in."""

import re

import pytest

from auv_bringup.launching.node_start import config_file, node_environment, reach_notes

RANGE, FILE = "ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE"


def environment(discovery, **environ):
    made = node_environment(environ, domain_id=7, discovery=discovery)
    return made[RANGE], made.get(FILE, "").rsplit("/", 1)[-1]


def test_a_run_on_this_machine_uses_the_profiles_that_close_it():
    assert environment("localhost") == ("SYSTEM_DEFAULT", "fastdds_localhost.xml")
    assert environment("subnet") == ("SUBNET", "fastdds.xml")
    again = node_environment({}, domain_id=7, discovery="localhost")
    assert node_environment(again, domain_id=7, discovery="localhost") == again
    assert node_environment(again, domain_id=7, discovery="subnet")[RANGE] == "SUBNET"


def test_without_fast_dds_and_with_profiles_of_the_user_the_range_stays_local():
    assert environment("localhost", RMW_IMPLEMENTATION="rmw_cyclonedds_cpp")[0] == "LOCALHOST"
    assert environment("localhost", **{FILE: "/mine.xml"}) == ("LOCALHOST", "mine.xml")


@pytest.mark.parametrize(
    ("environ", "discovery", "word"),
    [({}, "subnet", "every machine"), ({FILE: "/mine.xml"}, "localhost", "/mine")],
)
def test_what_is_open_is_said_in_one_line(environ, discovery, word):
    (line,) = reach_notes(environ, discovery)
    assert word in line
    assert reach_notes({}, "localhost") == []


def test_both_profiles_are_the_same_but_for_their_transports():
    transports = re.compile(
        r"\s*<(transport_descriptors|userTransports|useBuiltinTransports|metatrafficUnicastLocatorList"
        r"|initialPeersList)>.*?</\1>",
        re.DOTALL,
    )
    subnet, local = (
        config_file(name).read_text().partition("<dds")[2]
        for name in ("fastdds.xml", "fastdds_localhost.xml")
    )
    assert transports.sub("", local) == subnet
    assert local.count("127.0.0.1") == 3
