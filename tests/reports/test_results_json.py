"""results.json: fixed names, strict JSON."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from sample_results import bare, hostile, rich

from reports.results_json import to_json, write_json

PARAMETER = {
    "value",
    "std",
    "low",
    "high",
    "interval_50",
    "interval_80",
    "status",
    "reason",
    "prior",
    "reference",
    "sources",
    "refused",
}


def test_the_fixed_names_are_there() -> None:
    made = to_json(rich())
    assert {"cogest", "inputs", "import", "verdict", "estimates", "rollover"} <= made.keys()
    assert made["cogest"] == "0.1.0"
    assert {"log", "vehicle", "map", "settings", "seed"} <= made["inputs"].keys()
    assert made["inputs"]["log"]["path"] == "logs/slalom_35kph.vbo"
    assert made["inputs"]["log"]["sha256"] == "3f8a" * 16
    assert {"status", "messages", "rejected", "gaps", "clock", "signals", "notes"} <= made["import"].keys()
    assert made["import"]["rejected"] == {"row with too few columns": 1, "time runs backwards": 3}
    assert made["import"]["gaps"][0] == {"start_s": 30.2, "end_s": 33.9, "signal": None}
    assert made["import"]["signals"]["yaw_rate"]["channel"] == "YawRate"
    assert made["import"]["signals"]["yaw_rate"]["inverted"] is True
    for parameter in made["verdict"].values():
        assert set(parameter) == PARAMETER
        assert parameter["status"] in ("identified", "weak", "not_identifiable")
    height = made["verdict"]["cg_height_m"]
    assert height["value"] == 0.5581
    assert height["prior"]["value"] == 0.551
    assert height["prior"]["std"] == 0.034
    assert height["reference"] == 0.549
    for estimate in made["estimates"]:
        assert {
            "estimator",
            "status",
            "reason",
            "parameters",
            "used_fraction",
            "runtime_s",
        } <= estimate.keys()
        assert all(set(p) == PARAMETER for p in estimate["parameters"].values())
    assert made["rollover"]["static_stability_factor"]["value"] == 1.384
    assert made["rollover"]["peak_rollover_coefficient"] == 0.61


def test_what_is_not_finite_is_null_and_the_text_is_strict(tmp_path: Path) -> None:
    sample = rich()
    height = replace(sample.verdict["cg_height_m"], value=math.nan, high=math.inf, std=np.float64(0.1))
    write_json(replace(sample, verdict={"cg_height_m": height}), tmp_path / "results.json")

    def refuse(name: str) -> float:
        raise AssertionError(name)

    made = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"), parse_constant=refuse)
    assert made["verdict"]["cg_height_m"]["value"] is None
    assert made["verdict"]["cg_height_m"]["high"] is None
    assert made["verdict"]["cg_height_m"]["std"] == 0.1
    assert made["estimates"][0]["diagnostics"]["condition"] is None


def test_bare_and_hostile_results_are_json(tmp_path: Path) -> None:
    for sample in (bare(), hostile(), replace(bare(), vehicle_name="lone \ud800 surrogate")):
        write_json(sample, tmp_path / "results.json")
        json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert to_json(bare())["rollover"]["static_stability_factor"] is None
