"""What an importer finds in a log: its channels, and the chunks of columns that it yields."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
ByteArray = NDArray[np.uint8]

Family = Literal["table", "vbo", "ros", "can", "mdf", "json"]


@dataclass(frozen=True)
class ChannelInfo:
    """One channel of a log, before it is mapped to a signal.

    name: unique within the log; the name that a mapping file uses (design: CSV/VBO/MF4 column; bags and
        MCAP "/topic.field.path", lists "[0]"; CAN "Message.Signal").
    group: channels of one group share one time vector (a table, a topic, a CAN message and multiplexer).
    unit: as the log gives it, or None where the log is silent.
    family: which mapping profiles may look at it.
    kind: only "number" channels become signals; text is listed by `inspect` and never decoded.
    count: number of samples where the container's index knows it without reading, else None.
    tags: facts that profiles match on. ROS and JSON: "topic", "type" (as "sensor_msgs/Imu", without /msg/),
        "field" ("angular_velocity.z"), "element" (what the log calls the element of a list that it belongs to). CAN: "message", "signal", "id" (decimal, without the extended bit),
        "extended" ("1"), "pgn", "spn", "source_address", "bus", "builtin" ("1": of cogest's own definitions); what
        J1939 defines has its names for "message" and "signal", whatever the database calls them.
        Others: "column".
    """

    name: str
    group: str
    unit: str | None = None
    family: Family = "table"
    kind: Literal["number", "text"] = "number"
    count: int | None = None
    comment: str = ""
    tags: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Chunk:
    """Some rows of one group. NaN where a sample has no valid value ("not available", rejected, absent).

    time_ns: shape (n,), int64 nanoseconds on the log's clock (since 1970 where the log knows the wall clock,
        else since the log's own zero). Order as in the log: sorting is `parsers.timebase`'s work.
    columns: channel name -> shape (n,) float64, raw channel unit (scaled by the log's own conversion).
    own: whether no column's memory is anybody else's, another column's neither, so that it may be written over.
    """

    group: str
    time_ns: IntArray
    columns: Mapping[str, FloatArray]
    own: bool = False
