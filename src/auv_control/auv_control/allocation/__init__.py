"""
Allocation: from the wrench that a controller asks for to the forces of a vehicle's thrusters.

To add an allocator, write one file with ``Params`` and ``Allocator(params, thrusters, lost)``, a
`ThrusterAllocator`. The file's name is its ``kind``. `auv_core.thrusters` has the configuration matrix T.
An allocator is pure: the same wrench gives the same forces. After a thruster was lost, the agent makes a
second one, of a matrix without that thruster.
"""

from __future__ import annotations

from typing import Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.messages import Vec6
from auv_core.params import Section
from auv_core.thrusters import Thrusters

Forces = tuple[float, ...]


class ThrusterAllocator(Protocol):
    """Chooses forces of n thrusters."""

    def forces_n(self, tau: Vec6) -> Forces:
        """
        Return the forces (n,) (N, each along its thruster's direction) for a wrench.

        They lie within the thrusters' limits, and those of lost thrusters are 0.

        Parameters
        ----------
        tau : (6,) tuple
            Wrench to reach (N, N m; body FRD); all finite.

        """


def make_allocator(section: Section, thrusters: Thrusters, lost: tuple[int, ...] = ()) -> ThrusterAllocator:
    """
    Return the allocator of a section.

    Parameters
    ----------
    section : Section
        Kind and parameters.
    thrusters : Thrusters
        Of the vehicle.
    lost : tuple of int
        Numbers of the thrusters, from 1, that the vehicle knows to give no force.

    """
    made = class_of(__name__, section.kind, "Allocator")(section.params, thrusters, lost)
    allocator: ThrusterAllocator = fulfilled(made, ThrusterAllocator)
    return allocator
