"""
Layouts: the grouping of nodes into processes. Nodes, topics and numbers are the same in all of them.

* `node`: one process per node (that of the relay also has the clock).
* `vehicle`: vehicle and agent of one AUV in one process.
* `single`: all nodes in one process.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from auv_core.params import ConfigError

if TYPE_CHECKING:
    from auv_bringup.launching.node_specs import NodeSpec

LAYOUTS = ("node", "vehicle", "single")
DEFAULT_LAYOUT = "node"
MOST_PROCESSES = 32
"""Number of participants whose ports Fast DDS queries with ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST."""
MOST_IN_ONE_PROCESS = 128
"""
The middleware's work for nodes of one process grows with the square of their number: 254 vehicles take
minutes.
"""
CONTAINER = "/node_container"
"""Name of the process that holds all nodes."""


_PATIENCE_PER_PAIR_S = 0.002


def patience_s(vehicles: int) -> float:
    """
    Return how much the longest waits for an answer grow with the fleet (s, wall).

    If all vehicles hear each other, the work per tick grows with the number of pairs, and in one process no
    node answers before all are done. The value is about forty times the time on a quiet machine.
    """
    return _PATIENCE_PER_PAIR_S * vehicles * vehicles


def start_patience_s(vehicles: int) -> float:
    """Return the same for start and end of the nodes, which are work of the middleware (s, wall)."""
    return 5.0 * patience_s(vehicles)


@dataclass(frozen=True)
class ProcessSpec:
    """
    One process to start, with its nodes.

    `role` is that of its first node: relay, vehicle, agent or recorder. `vehicle_id` is empty unless all of
    its nodes belong to one vehicle.
    """

    name: str
    nodes: tuple[NodeSpec, ...]
    role: str
    vehicle_id: str

    @property
    def records(self) -> bool:
        """Whether it has a recorder, which needs time to close its bag."""
        return any(node.role == "recorder" for node in self.nodes)


def vehicles_of(processes: Sequence[ProcessSpec]) -> int:
    """Return the number of vehicles whose nodes are in some processes."""
    return sum(node.role == "vehicle" for process in processes for node in process.nodes)


def process_specs(nodes: Sequence[NodeSpec], layout: str) -> list[ProcessSpec]:
    """Return the processes of a layout, one of `LAYOUTS`, for the nodes of a run."""
    if layout == "single":
        return [ProcessSpec(CONTAINER, tuple(nodes), nodes[0].role, "")]
    groups: dict[str, list[NodeSpec]] = {}
    for node in nodes:
        shares = layout == "vehicle" and node.vehicle_id
        groups.setdefault(f"/{node.vehicle_id}" if shares else node.name, []).append(node)
    return [
        ProcessSpec(name, tuple(group), group[0].role, group[0].vehicle_id) for name, group in groups.items()
    ]


def check_layout(
    layout: str | None, *, mode: str, on_vehicle_loss: str, vehicles: int, discovery: str = "localhost"
) -> str:
    """
    Return the layout to use; `None` asks for the default.

    Raises
    ------
    ConfigError
        If the layout is not possible for the run, or for this number of vehicles with this discovery.

    """
    if mode == "inprocess":
        return _no_layout(layout)
    layout = layout or DEFAULT_LAYOUT
    if layout not in LAYOUTS:
        raise ConfigError(f"layout {layout!r} is not allowed; allowed: {', '.join(LAYOUTS)}")
    if layout == "single" and vehicles > MOST_IN_ONE_PROCESS:
        raise ConfigError(
            f"layout 'single' is not allowed for {vehicles} vehicles, whose nodes do not find each other in "
            f"one process in time; allowed: at most {MOST_IN_ONE_PROCESS} vehicles, or mode inprocess"
        )
    if discovery == "localhost" and _processes(layout, vehicles) > MOST_PROCESSES:
        fitting = [each for each in LAYOUTS if _processes(each, vehicles) <= MOST_PROCESSES]
        if vehicles > MOST_IN_ONE_PROCESS:
            fitting = ["mode inprocess"]
        raise ConfigError(
            f"layout {layout!r} is not allowed for {vehicles} vehicles, since discovery on one machine finds "
            f"{MOST_PROCESSES} processes and these are {_processes(layout, vehicles)}; "
            f"allowed: {', '.join(fitting)}, or discovery subnet"
        )
    if layout == "single" and on_vehicle_loss == "continue":
        raise ConfigError(
            "layout 'single' is not allowed with on_vehicle_loss: continue, since no vehicle of one process "
            "is lost alone; allowed: node, vehicle"
        )
    return layout


def _no_layout(layout: str | None) -> str:
    if layout is None:
        return DEFAULT_LAYOUT
    raise ConfigError(
        f"layout {layout!r} is not allowed with mode inprocess, which has no nodes; "
        "allowed with: lockstep, realtime"
    )


def _processes(layout: str, vehicles: int) -> int:
    """Return how many processes of a run take part in discovery, including the launcher's."""
    others = 3  # relay with clock, recorder, launcher
    return {"node": 2 * vehicles + others, "vehicle": vehicles + others}.get(layout, 2)
