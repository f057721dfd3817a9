"""Whatever the names: recordings of two drives never become one, where names tell the drives apart or clocks do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hypothesis import given, settings
from hypothesis import strategies as st

from pipelines.fleet.clocks import NS, Clock
from pipelines.fleet.group import group_folder
from pipelines.fleet.logs import Log
from pipelines.fleet.names import stem_of
from pipelines.fleet.together import Moments

T0 = 1_714_557_600
KINDS = {"can": "blf", "gps": "vbo", "imu": "csv", "": "mf4"}


@dataclass
class Truth:
    """Clocks by name, and which drive each file is of."""

    clocks: dict[str, Clock] = field(default_factory=dict)
    drive: dict[str, int] = field(default_factory=dict)

    def clock(self, log: Log) -> Clock | None:
        return self.clocks[log.name]

    def content(self, log: Log) -> Mapping[str, Moments] | None:
        # every recording has a signal that no other has
        return {log.name: Moments(0.0, 1.0)}


@st.composite
def folders(draw: st.DrawFn) -> Truth:
    """Drives of some cars, each with some recorders, in parts; cars at the same time, drives of one car apart."""
    truth = Truth()
    number = 0
    cars = draw(
        st.lists(st.sampled_from(["car1", "car2", "golf", "x_1", "7"]), min_size=1, max_size=3, unique=True)
    )
    for car in cars:
        at = T0 + draw(st.integers(0, 50))
        for run in range(draw(st.integers(1, 3))):
            number += 1
            length = draw(st.integers(20, 600))
            stamp = f"2024-05-01_{10 + run:02d}-00-00"
            style = draw(st.sampled_from([f"{car}_run{run}", f"{car}_{stamp}", f"{stamp}_{car}"]))
            for kind in draw(st.lists(st.sampled_from(sorted(KINDS)), min_size=1, max_size=3, unique=True)):
                parts = draw(st.integers(1, 3))
                for part in range(parts):
                    tail = "".join(f"_{word}" for word in (kind, f"{part:03d}" if parts > 1 else "") if word)
                    name = f"{style}{tail}.{KINDS[kind]}"
                    first, last = at + part * length / parts, at + (part + 1) * length / parts - 0.01
                    truth.clocks[name] = Clock(round(first * NS), round(last * NS), True)
                    truth.drive[name] = number
            at += length + draw(st.integers(2, 4000))
    return truth


@given(folders())
@settings(max_examples=120, deadline=None)
def test_no_two_drives_become_one(truth):
    formats = {"blf": "blf", "vbo": "vbo", "csv": "csv", "mf4": "mf4"}
    logs = [Log(f"/f/{n}", n, 10, stem_of(n), formats[n.rpartition(".")[2]], "") for n in truth.clocks]
    grouped = group_folder(logs, truth)
    found = [[log.name for log in drive.logs] for drive in grouped.drives]
    assert sorted(name for names in found for name in names) == sorted(truth.clocks)
    assert not grouped.left_out
    for names in found:
        assert len({truth.drive[name] for name in names}) == 1, names
