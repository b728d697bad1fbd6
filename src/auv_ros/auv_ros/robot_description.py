"""The hull of a vehicle as a URDF text, for RViz, Foxglove and other viewers."""

from __future__ import annotations

import math
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from auv_core.models import Handling

_HULL_RGBA = "0.25 0.55 0.95 0.6"
_BOW_RGBA = "0.9 0.25 0.2 1.0"


def robot_description(base_frame: str, body_frame: str, handling: Handling) -> str:
    """
    Return the URDF of a hull with a rod at its bow: a sphere, or a cylinder if it is longer than wide.

    Parameters
    ----------
    base_frame, body_frame : str
        Frame ids of the body: forward, left, up, and forward, right, down. They name the two links.
    handling : Handling
        Of the vehicle: it has the size of the hull, and the radius of the sphere around it, which collides.

    """
    hull_radius_m = handling.hull_radius_m
    robot = Element("robot", name=base_frame.split("/")[0])
    link = SubElement(robot, "link", name=base_frame)
    _add_visual(link, "hull", _HULL_RGBA)
    _add_hull(link[-1], handling)
    _add_visual(link, "bow", _BOW_RGBA)
    SubElement(link[-1], "origin", xyz=f"{hull_radius_m!r} 0 0", rpy=f"0 {math.pi / 2!r} 0")
    rod = SubElement(link[-1], "geometry")
    SubElement(rod, "cylinder", radius=repr(hull_radius_m / 10.0), length=repr(hull_radius_m / 2.0))
    _add_sphere(SubElement(link, "collision"), hull_radius_m)
    SubElement(robot, "link", name=body_frame)
    joint = SubElement(robot, "joint", name=f"{base_frame}_to_frd", type="fixed")
    SubElement(joint, "parent", link=base_frame)
    SubElement(joint, "child", link=body_frame)
    SubElement(joint, "origin", xyz="0 0 0", rpy=f"{math.pi!r} 0 0")
    return ElementTree.tostring(robot, encoding="unicode")


def _add_visual(link: Element, name: str, rgba: str) -> None:
    visual = SubElement(link, "visual", name=name)
    SubElement(SubElement(visual, "material", name=name), "color", rgba=rgba)


def _add_hull(visual: Element, handling: Handling) -> None:
    """Add the shape of a hull: a sphere, or a cylinder along the forward axis."""
    if handling.hull_length_m <= handling.hull_diameter_m:
        _add_sphere(visual, handling.hull_radius_m)
        return
    SubElement(visual, "origin", xyz="0 0 0", rpy=f"0 {math.pi / 2!r} 0")
    length, radius = repr(handling.hull_length_m), repr(0.5 * handling.hull_diameter_m)
    SubElement(SubElement(visual, "geometry"), "cylinder", radius=radius, length=length)


def _add_sphere(parent: Element, radius_m: float) -> None:
    SubElement(SubElement(parent, "geometry"), "sphere", radius=repr(radius_m))
