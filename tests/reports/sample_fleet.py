"""Made-up tables of a fleet: sizes that hang together, as a real store would hold them, and hostile ones."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np
import polars as pl

from pipelines.fleet.tables import TABLES, table
from reports.fleet.facts import FleetFacts

FIRST = datetime(2024, 3, 4, 6, 30, tzinfo=UTC)
REASONS = (
    ("error", "malformed log: {log}, line {line}: expected 14 columns, found 9"),
    ("timeout", "the drive took longer than 600 s (--time-limit)"),
    ("crashed", "the worker's process died (signal 9) while it read {log}"),
    ("memory", "the worker took more than 2.0 GB (--memory-limit)"),
)
SHARED = (
    ("empty_mass_kg", "mass, empty", "kg", 1720.0, 60.0),
    ("spring_rate_front_npm", "front spring rate", "N/m", 28_000.0, 2800.0),
    ("spring_rate_rear_npm", "rear spring rate", "N/m", 31_000.0, 3100.0),
    ("damper_rate_front_nspm", "front damper rate", "N·s/m", 2100.0, 400.0),
    ("damper_rate_rear_nspm", "rear damper rate", "N·s/m", 2300.0, 450.0),
    ("roll_stiffness_nmprad", "roll stiffness, empty", "N·m/rad", 92_000.0, 9000.0),
    ("imu_left_m", "inertial unit left of the middle", "m", 0.0, 0.05),
)
LOADS = {"cg_height_m": 0.025, "mass_kg": 38.0, "cg_to_front_axle_m": 0.022, "cg_lateral_offset_m": 0.012}
STATUSES = ("identified", "weak", "not_identifiable")


def facts(**others: object) -> FleetFacts:
    """What the page says about the batch itself."""
    known: dict[str, object] = {
        "folder": "/data/fleet", "store": "/data/store", "version": "0.1.0", "created": "2026-01-12 08:15 UTC",
        "false_alarm_rate": 0.01, "left_out": 3, "notes": ("3 files are no log (photos, a spreadsheet).",),
    }  # fmt: skip
    return FleetFacts(**{**known, **others})  # type: ignore[arg-type]


def empty_fleet() -> dict[str, pl.DataFrame]:
    """All tables, no row."""
    return {name: table(name, []) for name in TABLES}


def _answers(
    row: dict[str, object], truth: dict[str, float], rng: np.random.Generator
) -> list[dict[str, object]]:
    """The drive's own and the joined answer of each load parameter."""
    out: list[dict[str, object]] = []
    for name, std in LOADS.items():
        status = int(rng.choice(3, p=(0.55, 0.3, 0.15)))
        for source, spread in (("drive", std * (1 + status)), ("fleet", 0.55 * std)):
            value = truth[name] + spread * float(rng.standard_normal())
            shown = STATUSES[status] if source == "drive" else STATUSES[min(status, 1)]
            out.append(
                {
                    "drive_id": row["drive_id"], "vehicle_id": row["vehicle_id"], "start_utc": row["start_utc"],
                    "parameter": name, "source": source, "value": value, "std": spread,
                    "low": value - 1.96 * spread, "high": value + 1.96 * spread, "status": shown,
                    "reason": "from pitch balance by spring deflections", "prior": truth[name] + std, "prior_std": 3 * std,
                }
            )  # fmt: skip
    return out


def _drive(v: int, k: int, when: datetime | None, rng: np.random.Generator) -> dict[str, object]:
    name = f"van-{v:02d}/2024/drive_{k:04d}.mcap"
    drive_id = f"van-{v:02d}-drive-{k:04d}"
    return {
        "drive_id": drive_id, "drive": name, "vehicle_id": f"van-{v:02d}", "vehicle_name": f"Delivery van {v:02d}",
        "status": "done", "reason": "", "start_utc": None if when is None else when.isoformat(),
        "duration_s": float(rng.uniform(240, 5400)), "format": "MCAP", "import_status": "complete",
        "log_bytes": int(rng.integers(2_000_000, 90_000_000)), "logs": [f"/data/fleet/{name}"], "log_sha256": "ab" * 32, "key": "cd" * 32,
        "cogest": "0.1.0", "notes": ["no anti-roll bar rates in the vehicle file"] if k % 7 == 0 else [],
        "report": f"drives/{(v * 7) % 256:02x}/{drive_id}/report.html", "gone": False, "apart": None,
    }  # fmt: skip


def _failed(row: dict[str, object], rng: np.random.Generator) -> dict[str, object]:
    status, text = REASONS[int(rng.integers(len(REASONS)))]
    reason = text.format(log=row["drive"], line=int(rng.integers(10, 90_000)))
    return {
        **row,
        "status": status,
        "reason": reason,
        "duration_s": None,
        "import_status": None,
        "report": None,
    }


def _rollover(truth: dict[str, float], track: float, rng: np.random.Generator) -> dict[str, object]:
    factor = track / (2 * truth["cg_height_m"])
    threshold = 0.88 * factor
    peak = float(min(rng.gamma(6.0, 0.075), 0.99 * threshold))
    margin = threshold - peak + 0.02 * float(rng.standard_normal())
    return {
        "static_stability_factor": factor, "rollover_threshold_g": threshold, "least_margin_g": margin,
        "peak_lateral_acceleration_g": peak, "peak_rollover_coefficient": min(peak / threshold, 1.0),
        "exceedance_probability": float(np.clip(0.5 - 8 * margin, 0.0, 1.0)), "wheel_lifts": int(margin < 0.01),
    }  # fmt: skip


def _change(
    row: dict[str, object], before: str, kg: float, truth: dict[str, float], old: dict[str, float]
) -> dict[str, object]:
    moved = abs(kg) > 60
    text = (
        f"about {abs(kg):.0f} ± 24 kg {'more' if kg > 0 else 'less'}, CG {100 * abs(truth['cg_height_m'] - old['cg_height_m']):.1f} cm"
        if moved
        else "no change of the load is seen"
    )
    return {
        "vehicle_id": row["vehicle_id"], "drive_id": row["drive_id"], "before": before, "start_utc": row["start_utc"],
        "detected": moved, "probability": 2e-5 if moved else 0.4, "mass_change_kg": kg, "mass_change_std_kg": 24.0,
        "cg_height_change_m": truth["cg_height_m"] - old["cg_height_m"], "cg_height_change_std_m": 0.014,
        "cg_to_front_axle_change_m": truth["cg_to_front_axle_m"] - old["cg_to_front_axle_m"],
        "cg_to_front_axle_change_std_m": 0.012, "cg_lateral_change_m": 0.001, "cg_lateral_change_std_m": 0.006, "text": text,
    }  # fmt: skip


def _vehicle_rows(v: int, drives: int, rng: np.random.Generator) -> list[dict[str, object]]:
    out = []
    for k, (name, title, unit, mean, std) in enumerate(SHARED):
        after = std / (1.5 + drives**0.5 / (1 + k % 3))
        value = mean + after * float(rng.standard_normal())
        status = "not_identifiable" if name == "imu_left_m" else ("weak" if k % 3 == 2 else "identified")
        out.append(
            {
                "vehicle_id": f"van-{v:02d}", "vehicle_name": f"Delivery van {v:02d}", "parameter": name, "title": title,
                "unit": unit, "value": value, "std": after, "low": value - 1.96 * after, "high": value + 1.96 * after,
                "status": status, "reason": f"from {drives} drives", "prior": mean, "prior_std": std, "single_std": 0.8 * std, "doubts": [],
                "drives": drives,
            }
        )  # fmt: skip
    return out


def _trend_rows(v: int, drives: int, rng: np.random.Generator) -> list[dict[str, object]]:
    out = []
    for name, title, unit, mean, _ in SHARED[1:5]:
        slope = (
            -0.16 * mean
            if v == 2 and name == "damper_rate_rear_nspm"
            else 0.01 * mean * float(rng.standard_normal())
        )
        std = 0.025 * mean
        found = abs(slope) > 3 * std
        share = 100 * slope / mean
        out.append(
            {
                "vehicle_id": f"van-{v:02d}", "parameter": name, "title": title, "unit": unit, "per_year": slope, "std": std,
                "low": slope - 1.96 * std, "high": slope + 1.96 * std, "probability": 1e-7 if found else 0.5, "detected": found,
                "from_utc": FIRST.isoformat(), "to_utc": (FIRST + timedelta(days=3 * drives)).isoformat(), "drives": drives,
                "text": f"{'falls' if slope < 0 else 'rises'}: {share:+.1f} % a year" if found else f"no trend is seen: {share:+.1f} % a year",
            }
        )  # fmt: skip
    return out


def _outlier_rows(vehicles: int) -> list[dict[str, object]]:
    return [
        {
            "rank": k + 1, "vehicle_id": f"van-{(k + 3) % vehicles:02d}", "vehicle_name": f"Delivery van {(k + 3) % vehicles:02d}",
            "score": 5.2 / (k + 1), "probability": 1e-5 if k == 0 else min(0.9, 0.08 * k), "parameter": "roll_stiffness_nmprad",
            "value": 112_000.0 / (1 + 0.02 * k), "others": 92_000.0, "others_std": 3800.0,
            "text": f"{'Stands out' if k == 0 else 'Goes with the others of its kind'}: roll stiffness is {5.2 / (k + 1):.1f} standard deviations above the others'.",
        }
        for k in range(vehicles)
    ]  # fmt: skip


def sample_fleet(
    drives: int = 40, vehicles: int = 4, seed: int = 3, failed: float = 0.05, dated: float = 1.0
) -> dict[str, pl.DataFrame]:
    """Tables of a fleet. failed: share of drives that failed; dated: share that has a start."""
    rng = np.random.default_rng(seed)
    rows: dict[str, list[dict[str, object]]] = {name: [] for name in TABLES}
    for v in range(vehicles):
        own = drives // vehicles + (v < drives % vehicles)
        empty = {"cg_height_m": 0.71 + 0.03 * rng.standard_normal(), "mass_kg": 1720.0}
        track, load, before = 1.62, 120.0, ""
        truth: dict[str, float] = {}
        for k in range(own):
            if k and rng.random() < 0.2:
                load = float(rng.uniform(0, 600))
            old = truth
            truth = {
                "cg_height_m": float(empty["cg_height_m"]) + 1.5e-4 * load, "mass_kg": empty["mass_kg"] + load,
                "cg_to_front_axle_m": 1.28 + 4e-4 * load, "cg_lateral_offset_m": 0.004,
            }  # fmt: skip
            when = FIRST + timedelta(days=3 * k, minutes=17 * v + 95 * (k % 4))
            row = _drive(v, k, when if rng.random() < dated else None, rng)
            if rng.random() < failed:
                rows["drives"].append(_failed(row, rng))
                continue
            rows["drives"].append({**row, **_rollover(truth, track, rng)})
            rows["parameters"] += _answers(row, truth, rng)
            if before:
                rows["load_changes"].append(
                    _change(row, before, truth["mass_kg"] - old["mass_kg"], truth, old)
                )
            before = str(row["drive_id"])
        rows["vehicles"] += _vehicle_rows(v, own, rng)
        rows["trends"] += _trend_rows(v, own, rng)
    rows["outliers"] = _outlier_rows(vehicles)
    return {name: table(name, found) for name, found in rows.items()}


def tiled(tables: dict[str, pl.DataFrame], times: int) -> dict[str, pl.DataFrame]:
    """The same fleet several times over, each with names of its own: a large one, quickly made."""
    named = ("drive_id", "drive", "vehicle_id", "vehicle_name", "before")
    return {
        name: pl.concat(
            [
                frame.with_columns((pl.col(c) + f" copy {k}") for c in named if c in frame.columns)
                for k in range(times)
            ]
        )
        for name, frame in tables.items()
    }


HOSTILE = (
    "</script><img src=x onerror=alert(1)>",
    '=HYPERLINK("http://x")\n<!--<script>',
    "שלום \u202egnp.exe عربي",
    "deep/" * 60 + "drive.csv",
    "a\x00b\ud800c'\"&amp;{{ 7*7 }}",
    "javascript:alert(1)//",
)


def hostile_fleet() -> dict[str, pl.DataFrame]:
    """Every text in every table is hostile."""
    found = sample_fleet(12, 3, seed=5, failed=0.3)
    out: dict[str, pl.DataFrame] = {}
    bad = [text.encode("utf-8", "replace").decode() for text in HOSTILE]
    for name, frame in found.items():
        k = pl.int_range(pl.len()) % len(bad)
        texts = [
            c
            for c in ("drive", "vehicle_name", "reason", "text", "title", "unit", "report")
            if c in frame.columns
        ]
        picked = [
            k.replace_strict(list(range(len(bad))), [t[:40] if c == "unit" else t for t in bad]).alias(c)
            for c in texts
        ]
        frame = frame.with_columns(picked)
        if "vehicle_id" in frame.columns:
            frame = frame.with_columns(
                pl.concat_str([pl.col("vehicle_id"), pl.lit(bad[0])]).alias("vehicle_id")
            )
        out[name] = frame
    return out


def silent_fleet() -> dict[str, pl.DataFrame]:
    """Null in every column but the names."""
    found = sample_fleet(8, 2, seed=6, failed=0.0)
    keep = {"drive_id", "vehicle_id", "parameter", "source"}
    return {
        name: frame.with_columns(
            [pl.lit(None, dtype=kind).alias(c) for c, kind in frame.schema.items() if c not in keep]
        )
        for name, frame in found.items()
    }
