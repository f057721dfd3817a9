"""The manoeuvres that cogest can run: one line each, name -> "module:function"."""

from __future__ import annotations

import difflib
import importlib
from collections.abc import Mapping
from functools import cache
from typing import cast

import numpy as np

from parsers.errors import SettingsError
from pipelines.simulation.manoeuvres.base import Builder, Options, Scenario, VehicleFigures

_HERE = "pipelines.simulation.manoeuvres"

MANOEUVRES: Mapping[str, str] = {
    "sine_with_dwell": f"{_HERE}.sine_with_dwell:sine_with_dwell",
    "slowly_increasing_steer": f"{_HERE}.steering_ramps:slowly_increasing_steer",
    "step_steer": f"{_HERE}.steering_ramps:step_steer",
    "sine_sweep": f"{_HERE}.steering_sines:sine_sweep",
    "weave": f"{_HERE}.steering_sines:weave",
    "steady_circle": f"{_HERE}.steady_circle:steady_circle",
    "steady_circle_steps": f"{_HERE}.steady_circle:steady_circle_steps",
    "circle_35m": f"{_HERE}.steady_circle:circle_35m",
    "double_lane_change": f"{_HERE}.double_lane_change:double_lane_change",
    "obstacle_avoidance": f"{_HERE}.double_lane_change:obstacle_avoidance",
    "slalom": f"{_HERE}.slalom:slalom",
    "slalom_36m": f"{_HERE}.slalom:slalom_36m",
    "slalom_u_turns": f"{_HERE}.slalom:slalom_u_turns",
    "straight_braking": f"{_HERE}.braking:straight_braking",
    "straight_braking_basalt": f"{_HERE}.braking:straight_braking_basalt",
    "split_friction_braking": f"{_HERE}.braking:split_friction_braking",
    "launch_and_stop": f"{_HERE}.braking:launch_and_stop",
    "handling_track": f"{_HERE}.handling_track:handling_track",
    "urban": f"{_HERE}.public_roads:urban",
    "rural": f"{_HERE}.public_roads:rural",
    "hills": f"{_HERE}.public_roads:hills",
    "public_road": f"{_HERE}.public_roads:public_road",
    "rough_straight": f"{_HERE}.rough_ground:rough_straight",
    "off_road": f"{_HERE}.rough_ground:off_road",
    "mixed_minute": f"{_HERE}.mixed_minute:mixed_minute",
    "truck_flat": f"{_HERE}.truck:truck_flat",
    "truck_slope": f"{_HERE}.truck:truck_slope",
}


@cache
def builder_at(line: str) -> Builder:
    """The builder that a registry line names. Loaded when first asked for."""
    module, _, function = line.partition(":")
    return cast("Builder", getattr(importlib.import_module(module), function))


def title_of(name: str) -> str:
    """One line on a manoeuvre: the first of its builder's docstring, without the full stop."""
    return (builder_at(MANOEUVRES[name]).__doc__ or name).strip().splitlines()[0].rstrip(".")


def make_scenario(name: str, vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Build a manoeuvre for a vehicle. Raises SettingsError for an unknown name, naming the nearest."""
    if name not in MANOEUVRES:
        near = difflib.get_close_matches(name, MANOEUVRES, n=1, cutoff=0.5)
        raise SettingsError(
            f"there is no manoeuvre {name!r}",
            hint=f"did you mean {near[0]!r}?" if near else f"known are {', '.join(MANOEUVRES)}",
            wrong_usage=True,
        )
    return builder_at(MANOEUVRES[name])(vehicle, options, rng)
