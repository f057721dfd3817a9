"""What bindings make of a log's columns: signals, and what the record says of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from parsers.channels import ChannelInfo, FloatArray
from parsers.drive import MappedChannel, Signal
from parsers.importer import ImportLog
from parsers.intake import Group
from parsers.mapping import Binding, bind
from parsers.signals import SIGNALS
from parsers.units import SI_TEXT

MIN_SAMPLES = 2
"""A channel with fewer valid samples than this is no signal."""
_BLOCK = 1 << 14


def _bound(binding: Binding, columns: Mapping[str, FloatArray], *, in_place: bool) -> FloatArray:
    """`bind` block by block: what it makes in between then stays in the processor's cache.

    in_place: over the main channel, which nobody needs any more; fresh memory takes longer than the arithmetic.
    """
    columns = {name: columns[name] for name in binding.needed}
    main = columns[binding.channels[0]]
    n = len(main)
    values = main if in_place else np.empty(n)
    # bytes that damage put there may be no numbers at all (signalling ones warn): what is not finite is dropped later
    with np.errstate(invalid="ignore", over="ignore"):
        for start in range(0, n, _BLOCK):
            part = {name: column[start : start + _BLOCK] for name, column in columns.items()}
            values[start : start + _BLOCK] = bind(binding, part)
    return values


def given(binding: Binding, columns: Mapping[str, FloatArray]) -> int:
    """How many rows have a number for a binding that may refuse some; 0 where it takes what it gets, or picks rows."""
    if not (_by_covariance(binding) or _by_fix(binding)) and (
        binding.where is not None or (binding.valid_range is None and binding.kind in ("scale", "length"))
    ):
        return 0
    whole = np.logical_and.reduce([np.isfinite(columns[name]) for name in binding.channels])
    return int(np.count_nonzero(whole))


def _by_covariance(binding: Binding) -> bool:
    """Whether a message itself says, by a covariance below zero, that it has no such value."""
    return binding.where is not None and "covariance" in binding.where[0].rsplit("/", 1)[-1]


def _by_fix(binding: Binding) -> bool:
    """Whether a receiver itself says that it has no fix, by a status below zero or a place at 0° and 0°."""
    return binding.beside is not None or (
        binding.where is not None and binding.where[0].endswith("status.status")
    )


def refused(binding: Binding) -> str:
    """Why the record counts a value that a binding had and did not take."""
    if _by_covariance(binding):
        return f"{binding.signal}: message that says it has none (covariance below 0), or value outside of its valid range"
    if _by_fix(binding):
        return f"{binding.signal}: row without a position fix, or value outside of its valid range"
    if binding.kind in ("scale", "length"):
        return f"{binding.signal}: value outside of its valid range"
    return f"{binding.signal}: quaternion that is none, or value outside of its valid range"


def make_signal(
    binding: Binding,
    groups: Mapping[str, Group],
    infos: Mapping[str, ChannelInfo],
    log: ImportLog,
    *,
    last: bool,
) -> Signal | None:
    """A binding's signal, or None where its channel has too few valid samples. last: nobody else needs the channel."""
    group = groups.get(group_of(binding, infos))
    if group is None or any(name not in group.columns for name in binding.channels):
        return None
    offered = given(binding, group.columns)
    values = _bound(binding, group.columns, in_place=last and binding.channels[0] in group.own)
    valid = np.isfinite(values)
    count = int(np.count_nonzero(valid))
    log.reject(refused(binding), max(offered - count, 0))
    if count < MIN_SAMPLES:
        return None
    whole = count == len(values)
    return Signal(
        binding.signal,
        group.time_ns if whole else group.time_ns[valid],
        values if whole else values[valid],
        source_text(binding),
        group=group_of(binding, infos),
    )


def group_of(binding: Binding, infos: Mapping[str, ChannelInfo]) -> str:
    """The group in whose rows a binding's channels are."""
    return binding.group or infos[binding.channels[0]].group


def source_text(binding: Binding) -> str:
    """The channels of a binding as a signal's source."""
    return " + ".join(binding.channels)


def mapped_channel(
    binding: Binding, samples: int, period_s: float, proposed: Iterable[Binding]
) -> MappedChannel:
    """What the record says of a binding that was chosen out of the proposed ones. period_s: 0 where there is none."""
    others = (source_text(other) for other in proposed if other is not binding)
    return MappedChannel(
        signal=binding.signal,
        channel=source_text(binding),
        unit=binding.unit.text or SI_TEXT[SIGNALS[binding.signal].quantity],
        unit_from=binding.unit_from,
        rule=binding.rule,
        samples=samples,
        rate_hz=1 / period_s if period_s > 0 else 0.0,
        scale=binding.scale,
        offset=binding.offset,
        inverted=binding.invert,
        alternatives=tuple(dict.fromkeys(others)),
    )


def is_stated(binding: Binding) -> bool:
    """Whether a binding's unit is known, not assumed."""
    return not binding.unit_from.startswith("assumed")
