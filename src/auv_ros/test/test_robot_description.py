"""The hull of every preset as a URDF that parsers accept: one tree of links, one shape in each geometry."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import yaml

import auv_core.models
from auv_core.models import make_model
from auv_core.params import load_section
from auv_ros.robot_description import robot_description

PRESETS = sorted((Path(auv_core.models.__file__).parent / "presets").glob("*.yaml"))


@pytest.fixture(params=PRESETS, ids=lambda path: path.stem)
def hull(request):
    """Return how a preset handles, and its description."""
    section = load_section(yaml.safe_load(request.param.read_text()), "model", "auv_core.models")
    handling = make_model(section).handling
    text = robot_description("auv_1/base_link", "auv_1/base_link_frd", handling)
    return handling, ElementTree.fromstring(text)


def test_its_shape_is_the_hull(hull):
    handling, robot = hull
    radius_m = handling.hull_radius_m
    link = robot.find("link")
    assert link.get("name") == "auv_1/base_link"
    spheres = [float(sphere.get("radius")) for sphere in link.iter("sphere")]
    if handling.hull_length_m == handling.hull_diameter_m:
        assert spheres == [radius_m, radius_m]  # what is seen, and what collides
        return
    assert spheres == [radius_m]
    cylinder = link.find("visual").find("geometry").find("cylinder")
    assert float(cylinder.get("length")) == handling.hull_length_m
    assert float(cylinder.get("radius")) == 0.5 * handling.hull_diameter_m


def test_it_is_a_valid_robot(hull):
    _, robot = hull
    assert robot.tag == "robot"
    assert robot.get("name")
    links = [link.get("name") for link in robot.findall("link")]
    assert len(set(links)) == len(links)
    joints = [(j.find("parent").get("link"), j.find("child").get("link")) for j in robot.findall("joint")]
    assert [joint.get("type") for joint in robot.findall("joint")] == ["fixed"]
    assert {name for pair in joints for name in pair} <= set(links)
    assert sorted(child for _, child in joints) == sorted(set(links) - {"auv_1/base_link"})
    for geometry in robot.iter("geometry"):
        assert len(geometry) == 1
        assert geometry[0].tag in {"box", "cylinder", "sphere", "mesh"}
    for origin in robot.iter("origin"):
        assert len(origin.get("xyz").split()) == len(origin.get("rpy").split()) == 3
    for color in robot.iter("color"):
        assert all(0.0 <= float(number) <= 1.0 for number in color.get("rgba").split())
