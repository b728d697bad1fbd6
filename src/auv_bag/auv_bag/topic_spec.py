"""What is known of a topic of the graph."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class TopicSpec:
    """One topic of the graph.

    Attributes
    ----------
    name, type_name
        Full topic name and full type name.
    latched
        Published transient local: messages from before the start of the recorder are recorded, too.
    stamped
        Whether the stamp in its messages is the run's time; if not, it is the wall clock's.
    shared
        Whether several nodes publish it; the order of messages of one time then has no meaning.
    publisher, readers
        The kind of node that publishes it, and which nodes of a run read it.
    every_ticks
        Control periods between messages; 0 if `comes` describes it.
    comes
        Text that says when its messages come, or completes `every_ticks`.
    fields
        Text on the fields that matter.
    silence
        Text on the meaning of silence.
    """

    name: str
    type_name: str
    latched: bool = False
    stamped: bool = True
    shared: bool = False
    publisher: str = ""
    readers: str = ""
    every_ticks: int = 0
    comes: str = ""
    fields: str = ""
    silence: str = ""
