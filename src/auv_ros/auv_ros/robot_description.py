"""The hull of a vehicle as a URDF text, for RViz, Foxglove and other viewers."""

from __future__ import annotations

import math
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

_HULL_RGBA = "0.25 0.55 0.95 0.6"
_BOW_RGBA = "0.9 0.25 0.2 1.0"


def robot_description(base_frame: str, body_frame: str, hull_radius_m: float) -> str:
    """
    Return the URDF of a spherical hull with a rod at its bow.

    Parameters
    ----------
    base_frame, body_frame : str
        Frame ids of the body: forward, left, up, and forward, right, down. They name the two links.
    hull_radius_m : float
        Radius of the sphere around the hull (m).

    """
    robot = Element("robot", name=base_frame.split("/")[0])
    link = SubElement(robot, "link", name=base_frame)
    _add_visual(link, "hull", _HULL_RGBA)
    _add_sphere(link[-1], hull_radius_m)
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


def _add_sphere(parent: Element, radius_m: float) -> None:
    SubElement(SubElement(parent, "geometry"), "sphere", radius=repr(radius_m))
