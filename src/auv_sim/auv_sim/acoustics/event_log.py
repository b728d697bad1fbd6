"""The order of the acoustic log, and a check for receptions that must not happen."""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable, Sequence

from auv_core.messages import AcousticEvent, Outcome

_TOUCH_S = 1e-7


def in_order(events: Iterable[AcousticEvent]) -> list[AcousticEvent]:
    """
    Return events in the order of (time, source, sequence, destination).

    The time of a transmission is its start, that of a reception its end.
    """
    return sorted(events, key=_key)


def half_duplex_violations(events: Iterable[AcousticEvent]) -> list[tuple[AcousticEvent, AcousticEvent]]:
    """
    Return (transmission, reception) of every modem that received while it transmitted; this must be empty.

    Parameters
    ----------
    events : iterable of AcousticEvent
        The log of a whole run, in any order.

    """
    events = list(events)
    on_air: defaultdict[int, list[AcousticEvent]] = defaultdict(list)
    for event in events:
        if event.outcome == Outcome.SENT and event.end_s > event.start_s:
            on_air[event.source].append(event)
    for own in on_air.values():
        own.sort(key=lambda event: event.end_s)
    ends_s = {source: [event.end_s for event in own] for source, own in on_air.items()}
    found = []
    for event in events:
        if event.outcome != Outcome.DELIVERED or event.destination not in on_air:
            continue
        own = on_air[event.destination]
        for sent in _while(event, own, ends_s[event.destination]):
            found.append((sent, event))
    return found


def _while(
    event: AcousticEvent, own: Sequence[AcousticEvent], ends_s: Sequence[float]
) -> list[AcousticEvent]:
    """Return the transmissions, sorted by their ends, that overlap with a reception."""
    overlapping = []
    for sent in own[bisect_left(ends_s, event.start_s + _TOUCH_S) :]:
        if sent.start_s >= event.end_s - _TOUCH_S:
            break
        if min(sent.end_s, event.end_s) - max(sent.start_s, event.start_s) > _TOUCH_S:
            overlapping.append(sent)
    return overlapping


def _key(event: AcousticEvent) -> tuple[float, int, int, int]:
    time_s = event.start_s if event.outcome == Outcome.SENT else event.end_s
    return (time_s, event.source, event.sequence, event.destination)
