"""Logs in which most bytes are of no use, for the tests and the benchmark of what is fetched of a remote log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

FRAME_BYTES = 1_000_000


def with_camera(source: Path, target: Path, share: float, times: int, compression: CompressionType) -> None:
    """The first `share` of an MCAP log's messages, and a camera topic that is `times` as large, evenly among them."""
    with source.open("rb") as file:
        reader = make_reader(file)
        messages = list(reader.iter_messages())
    messages = messages[: round(share * len(messages))]
    wanted = sum(len(message.data) for _, _, message in messages)
    frames = max(1, round(times * wanted / FRAME_BYTES))
    every = max(1, len(messages) // frames)
    rng = np.random.default_rng(1)
    writer = Writer(str(target), chunk_size=4 << 20, compression=compression)
    writer.start()
    schemas: dict[int, int] = {}
    channels: dict[int, int] = {}
    camera = writer.register_channel("/camera", "octets", 0)
    for number, (schema, channel, message) in enumerate(messages):
        if schema.id not in schemas:
            schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
        if channel.id not in channels:
            channels[channel.id] = writer.register_channel(
                channel.topic, channel.message_encoding, schemas[schema.id]
            )
        writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
        if number % every == 0:
            writer.add_message(camera, message.log_time, rng.bytes(FRAME_BYTES), message.log_time)
    writer.finish()
