"""Messages of a bag as rows of bytes, grouped by topic and size, which NumPy reads at once."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from auv_bag.mcap_scan import McapScan

Bytes = NDArray[np.uint8]

_BATCH_BYTES = 16_000_000
_HEAD = np.dtype([("channel", "<u2"), ("sequence", "<u4"), ("time_ns", "<u8"), ("published_ns", "<u8")])
"""Data before the bytes of a message in its record."""


class MessageRows(NamedTuple):
    """
    Messages of one topic and one size.

    Attributes
    ----------
    order : (n, 2) array of uint64
        Log time (ns) of each message and its place in the bag, which orders messages of one time.
    data : (n, size) array of uint8
        The serialised messages.

    """

    topic: str
    type_name: str
    order: NDArray[np.uint64]
    data: Bytes


def message_rows(files: Sequence[McapScan], topics: Collection[str]) -> Iterator[MessageRows]:
    """
    Yield the messages of some topics in parts, so that only a small part of the bag is in memory.

    Parameters
    ----------
    files : sequence of McapScan
        Files of one bag, in recorded order.
    topics : collection of str
        Names of the topics.

    Raises
    ------
    BagError
        If a file is damaged.

    """
    n_before = 0
    for file in files:
        for buffer, places in _batches(file):
            yield from _rows(file, buffer, places, topics, n_before)
            n_before += len(places)


def _batches(file: McapScan) -> Iterator[tuple[bytes, NDArray[np.int64]]]:
    """
    Yield the bytes of several blocks, and where in them each message begins, including its head, and ends.
    """
    buffers: list[bytes] = []
    places: list[NDArray[np.int64]] = []
    n_bytes = 0
    for block in file.blocks():
        buffer, found = file.message_places(block)
        buffers.append(buffer)
        places.append(np.frombuffer(found, np.int64).reshape(-1, 2) + n_bytes)
        n_bytes += len(buffer)
        if n_bytes >= _BATCH_BYTES:
            yield b"".join(buffers), np.concatenate(places)
            buffers, places, n_bytes = [], [], 0
    if n_bytes:
        yield b"".join(buffers), np.concatenate(places)


def _rows(
    file: McapScan, buffer: bytes, places: NDArray[np.int64], topics: Collection[str], n_before: int
) -> Iterator[MessageRows]:
    """Yield the messages of some bytes by topic and size."""
    data = np.frombuffer(buffer, np.uint8)
    starts, sizes = places[:, 0] + _HEAD.itemsize, places[:, 1] - places[:, 0] - _HEAD.itemsize
    heads = sliding_window_view(data, _HEAD.itemsize)[places[:, 0]].view(_HEAD)[:, 0]
    wanted = [number for number, channel in file.channels.items() if channel.topic in topics]
    kept = np.flatnonzero(np.isin(heads["channel"], wanted))
    kept = kept[np.lexsort((sizes[kept], heads["channel"][kept]))]
    is_other = (np.diff(heads["channel"][kept]) != 0) | (np.diff(sizes[kept]) != 0)
    if not len(kept):
        return
    for group in np.split(kept, np.flatnonzero(is_other) + 1):
        first = group[0]
        channel = file.channels[int(heads["channel"][first])]
        order = np.stack([heads["time_ns"][group], (group + n_before).astype(np.uint64)], axis=1)
        rows = sliding_window_view(data, int(sizes[first]))[starts[group]]
        yield MessageRows(channel.topic, file.schemas[channel.schema_id].name, order, rows)
