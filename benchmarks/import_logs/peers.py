"""The same job with the libraries that engineers use today: from a file to columns in memory."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

Columns = dict[str, np.ndarray]


def python_can(path: Path, dbc: Path) -> Columns:
    """python-can's reader and cantools' decoder, frame by frame."""
    import can
    import cantools

    database = cantools.database.load_file(str(dbc))
    known = {message.frame_id: message for message in database.messages}
    lists: dict[str, list[float]] = {}
    with can.LogReader(str(path)) as reader:
        for frame in reader:
            message = known.get(frame.arbitration_id)
            if message is not None:
                values = message.decode(frame.data)
                for name, value in values.items():
                    lists.setdefault(f"{message.name}.{name}", []).append(value)
    return {name: np.array(values) for name, values in lists.items()}


def asammdf(path: Path, dbc: Path) -> Columns:
    """asammdf's bus logging extraction; its groups carry the identifier, from which the message's name follows."""
    from asammdf import MDF
    from cantools.database import load_file

    names = {message.frame_id: message.name for message in load_file(str(dbc)).messages}
    with MDF(path) as mdf, mdf.extract_bus_logging({"CAN": [(str(dbc), 0)]}) as out:
        return {
            f"{names[int(group.channel_group.acq_name.split('ID=')[1].split()[0], 16)]}.{channel.name}": out.get(
                channel.name, group=g, index=c
            ).samples
            for g, group in enumerate(out.groups)
            for c, channel in enumerate(group.channels)
            if c
        }


def rosbags(path: Path, wanted: tuple[str, ...]) -> Columns:
    """rosbags' reader, message by message, the wanted fields only."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    topics: dict[str, list[list[str]]] = {}
    for name in wanted:
        topic, *fields = name.split(".")
        topics.setdefault(topic, []).append(fields)
    lists: dict[str, list[float]] = {name: [] for name in wanted}
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        connections = [c for c in reader.connections if c.topic in topics]
        for connection, _, raw in reader.messages(connections):
            message = reader.deserialize(raw, connection.msgtype)
            for fields in topics[connection.topic]:
                value: Any = message
                for field in fields:
                    value = getattr(value, field)
                lists[".".join([connection.topic, *fields])].append(value)
    return {name: np.array(values) for name, values in lists.items()}


def _mcap(path: Path, fields: tuple[str, ...], decode: Callable[[Any, Any, Any], Any]) -> Columns:
    from mcap.reader import make_reader

    lists: dict[str, list[float]] = {}
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            body = decode(schema, channel, message)
            for field in fields:
                lists.setdefault(f"{channel.topic}.{field}", []).append(body(field))
    return {name: np.array(values) for name, values in lists.items()}


def mcap_json(path: Path, fields: tuple[str, ...]) -> Columns:
    """mcap's reader and orjson."""
    import orjson

    return _mcap(path, fields, lambda schema, channel, message: orjson.loads(message.data).__getitem__)


def mcap_protobuf(path: Path, fields: tuple[str, ...]) -> Columns:
    """mcap's reader and mcap-protobuf-support."""
    from functools import partial

    from mcap_protobuf.decoder import DecoderFactory

    factory = DecoderFactory()
    decoders: dict[int, Any] = {}

    def decode(schema: Any, channel: Any, message: Any) -> Any:
        decoder = decoders.get(channel.id)
        if decoder is None:
            decoder = decoders[channel.id] = factory.decoder_for(channel.message_encoding, schema)
        return partial(getattr, decoder(message.data))

    return _mcap(path, fields, decode)


def polars_csv(path: Path) -> Columns:
    """polars' CSV reader."""
    import polars as pl

    frame = pl.read_csv(path)
    return {name: frame.get_column(name).to_numpy() for name in frame.columns}


def pandas_csv(path: Path) -> Columns:
    """pandas' CSV reader."""
    import pandas as pd

    frame = pd.read_csv(path)
    return {str(name): frame[name].to_numpy() for name in frame.columns}


def polars_vbo(path: Path) -> Columns:
    """polars' CSV reader on the body of a VBO file."""
    import io

    import polars as pl

    text = path.read_bytes()
    at = text.index(b"[data]") + 8
    names = text[text.index(b"[column names]") : at].decode("latin-1").splitlines()[1].split()
    frame = pl.read_csv(
        io.BytesIO(text[at:]), separator=" ", has_header=False, new_columns=names, eol_char="\n"
    )
    return {name: frame.get_column(name).to_numpy() for name in frame.columns}
