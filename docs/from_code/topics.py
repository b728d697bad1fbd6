"""Every topic of a run."""

from __future__ import annotations

from auv_bag.topic_spec import TopicSpec
from auv_bag.topics import COMMON_TOPICS, VEHICLE_TOPICS
from from_code.markdown import code


def topics() -> str:
    """Return all topics."""
    return "\n".join(
        [
            "## Of each vehicle\n",
            "In the namespace of the vehicle: `state` of `auv_1` is `/auv_1/state`.\n",
            *map(_part, VEHICLE_TOPICS),
            "## Of the run\n",
            *map(_part, COMMON_TOPICS),
        ]
    )


def when(topic: TopicSpec) -> str:
    """Return a text that says when the messages of a topic come."""
    often = {0: "", 1: "every tick"}.get(topic.every_ticks, f"every {topic.every_ticks} ticks")
    return ", ".join(filter(None, [often, topic.comes]))


def _part(topic: TopicSpec) -> str:
    return (
        f"### {code(topic.name)}\n\n"
        f"{_type_words(topic.type_name)}, {'latched' if topic.latched else 'volatile'}<br>\n"
        f"from {topic.publisher} to {topic.readers}<br>\n"
        f"{when(topic)}\n\n"
        f"{topic.fields}\n\n"
        f"*Silence:* {topic.silence}\n"
    )


def _type_words(type_name: str) -> str:
    package, _, name = type_name.split("/")
    words = f"{package}/{name}"
    return f"[{code(words)}](messages.md#{name.lower()})" if package == "auv_msgs" else code(words)
