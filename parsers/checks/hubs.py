"""Accelerations over the wheels that are as large as hubs have: of a sensor on the hub, whose name does not say so."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parsers.checks.wording import show
from parsers.drive import Decision, Signal
from parsers.signals import WHEELS

SHAKEN_MPS2 = 12.0
"""Spread that no body has over a drive: on the roughest tracks it is a third of that, and hubs have it on plain roads."""

TIMES, LEAST_MPS2 = 5.0, 5.0
"""Over the spread of the body's own vertical acceleration, where the log has it: what its ends do beside its middle is two times as much, with
what a low-pass took from that one three times."""

GRAVITIES_MPS2 = 40.0
"""A mean beyond it is of another unit, which makes any body shake."""


def hub_motion(signals: Mapping[str, Signal]) -> dict[str, Decision]:
    """The bodies' accelerations over the wheels that are left out for it, each with its decision."""
    corners = (signals.get(f"accel_z_sprung_{wheel}") for wheel in WHEELS)
    own = {
        each.name: float(np.std(each.values))
        for each in corners
        if each is not None and len(each.values) and abs(float(np.mean(each.values))) < GRAVITIES_MPS2
    }
    if not own:
        return {}
    # of all wheels together: one bad sensor is no hub
    usual = float(np.median(list(own.values())))
    body = signals.get("accel_z")
    spread = float(np.std(body.values)) if body is not None and len(body.values) else None
    beside = spread is not None and usual > max(TIMES * spread, LEAST_MPS2)
    if usual < SHAKEN_MPS2 and not beside:
        return {}
    evidence = f"spread {show('accel_z', usual)}" + (
        f", accel_z {show('accel_z', spread)}" if beside and spread is not None else ""
    )
    return {
        name: Decision(
            name, "range", f"{name} is shaken as a hub is, not as a body above it",
            f'left out; where the sensor is on the hub, a mapping file says [signals.{name.replace("_sprung", "_unsprung")}] '
            f'channel = "{signals[name].source}"',
            evidence, applied=True,
        )
        for name in own
    }  # fmt: skip
