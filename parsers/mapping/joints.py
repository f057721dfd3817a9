"""Joint states by place: a number's place in the message says which joint it is only as long as every message lists the joints alike."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.bindings import Binding

TYPE = "sensor_msgs/JointState"


def say_joints(
    proposals: Mapping[str, Sequence[Binding]], channels: Iterable[ChannelInfo]
) -> tuple[str, ...]:
    """A sentence on the topics of joint states that a mapping file takes signals from."""
    topic_of = {
        each.name: each.tags.get("topic", each.group)
        for each in channels
        if each.tags.get("type") == TYPE and "joint" not in each.tags
    }
    taken: dict[str, list[str]] = {}
    for signal, bindings in proposals.items():
        for topic in {topic_of[name] for name in bindings[0].channels if name in topic_of}:
            taken.setdefault(topic, []).append(signal)
    return tuple(
        f"{', '.join(signals)}: of {topic}, by place in the message, so that joints are mixed up where "
        "publishers share the topic or list them in another order"
        for topic, signals in taken.items()
    )
