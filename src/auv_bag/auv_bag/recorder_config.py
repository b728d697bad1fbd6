"""The settings of a recorder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from auv_bag.link import Opening
from auv_bag.topic_spec import TopicSpec
from auv_bag.topics import LOG_TOPIC, topics_of_graph
from auv_core.messages import COMMANDS
from auv_core.params import param

_COMMON_LOGGERS = ("acoustic_relay_node", "clock_node", "recorder_node")


@dataclass(frozen=True, kw_only=True)
class RecorderConfig:
    """The topics to record, and the bag."""

    bag_dir: str = param("folder of the bag; it must not exist yet")
    topics_vehicles: tuple[str, ...] = param("ids of the vehicles whose topics are recorded")
    commands: tuple[str, ...] = param("kind of command that each of these vehicles takes", choices=COMMANDS)
    publishers: str = param(
        "accepted publishers: own, the nodes of this run only; any, also modem drivers or navigations",
        default="own",
        choices=("own", "any"),
    )
    mode: str = param("how the run keeps time", default="realtime", choices=("lockstep", "realtime"))

    @property
    def opening(self) -> Opening:
        """What the process that writes the bag must know."""
        is_lockstep = self.mode == "lockstep"
        topics = topics_of_graph(self.topics_vehicles, self.commands, lockstep=is_lockstep)
        return Opening(Path(self.bag_dir), tuple(topics), is_lockstep)

    @property
    def own_loggers(self) -> tuple[str, ...]:
        """Beginnings of the names of the loggers of the run."""
        return (*_COMMON_LOGGERS, *(f"{name}." for name in self.topics_vehicles))

    def admits_strangers(self, spec: TopicSpec) -> bool:
        """Return whether foreign publishers of a topic are recorded."""
        return self.publishers == "any" or spec.name == LOG_TOPIC
