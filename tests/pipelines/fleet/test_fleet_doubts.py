"""What a drive says against its own figures, for who sees the joined ones alone."""

from __future__ import annotations

from dataclasses import replace

from parsers.drive import Decision
from pipelines.fleet.doubts import MOST, doubts_of, vehicle_doubts
from pipelines.hierarchy.records import VehicleKnowledge
from pipelines.results import JointVerdict, RelationCheck
from tests.reports.sample_results import rich


def test_a_drives_doubts() -> None:
    whole = rich()
    against = RelationCheck("roll balance", "load_balance", 4, 30.0, 1e-6, 2.6, "")
    fits = RelationCheck("pitch balance", "load_balance", 4, 3.0, 0.5, 1.0, "")
    mended = Decision("accel_x", "sign", "accel_x is the wrong way round", "inverted", "e", True)
    found = (
        mended,
        replace(mended, applied=False),
        Decision("speed", "load", "the load changed by 300 kg at 90 s", "told weakly", "e", True),
    )
    verdict = {
        name: replace(entry, refused="one of them is wrong; ") if name == "mass_kg" else entry
        for name, entry in whole.verdict.items()
    }
    drive = replace(
        whole,
        verdict=verdict,
        joint=JointVerdict({}, (against, fits), far=("load (+3.0)",), spoke_for=("springs by air",)),
        record=replace(whole.record, status="complete", decisions=found),
    )
    assert doubts_of(drive) == (
        "one of them is wrong",
        "roll balance contradicts the rest",
        "springs by air",
        "ended far from what was known: load (+3.0)",
        "the load changed by 300 kg at 90 s",
        "accel_x is the wrong way round: not corrected",
    )
    plain = replace(drive, verdict=whole.verdict, joint=None, record=replace(drive.record, decisions=()))
    assert doubts_of(plain) == ()


def test_what_is_said_of_a_vehicle() -> None:
    """What was done with its drives first; a drive that was left out has no say, and many are counted."""
    knowledge = VehicleKnowledge(
        "v", {}, {}, (), (), ("nothing to join in d9",), {"d0": ("d0 was left out",)}, {"d0": "misfit"}
    )
    names = {f"d{i}": f"v/{i}.csv" for i in range(6)}
    said = dict.fromkeys(names, ("springs by air",))
    said["d2"] = ("truncated", "springs by air")
    assert vehicle_doubts(knowledge, said, names) == [
        "nothing to join in d9",
        "d0 was left out",
        "v/1.csv, v/2.csv, v/3.csv and 2 more: springs by air",
        "v/2.csv: truncated",
    ]
    many = {"d1": tuple(f"doubt {i}" for i in range(MOST + 5))}
    assert len(vehicle_doubts(knowledge, many, names)) == MOST + 1
    assert vehicle_doubts(knowledge, many, names)[-1] == "and 7 more"
