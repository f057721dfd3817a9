"""How fast a drive of 100 s at 1 kHz goes through LTM, MLTM and HFLTM, beside a plain numpy loop of the same filter.

python benchmarks/load_transfer_speed.py [seconds]

The target: HFLTM with the settings of Table 8.1 in under 2 s. The peer does the same steps with numpy's matrix products
and solver, a sample at a time; it is timed on a part of the drive.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1])]

from pipelines.estimators.load_transfer.filtering import (  # noqa: E402
    FilterSettings,
    collocation_of,
    inputs_of,
    run_filter,
    table_settings,
)
from pipelines.estimators.load_transfer.kernels import HFLTM, LTM, MLTM  # noqa: E402
from pipelines.reproduce.load_transfer.plant import RATE_HZ, SIZE, forces, matched_drive  # noqa: E402
from pipelines.reproduce.load_transfer.study import TITLES, working_settings  # noqa: E402

TARGET_S = 2.0
PEER_ROWS = 1500


def peer_seconds(inputs: np.ndarray, measured: np.ndarray, settings: FilterSettings) -> float:
    """HFLTM in numpy, a sample at a time, in s."""
    chosen = collocation_of(HFLTM, settings, np.random.default_rng(0))
    start = np.array(settings.start)
    count, turned = len(start), chosen.matrix.T
    x = np.zeros((count, len(chosen.indices)))
    x[:, 0] = start[:, 0]
    width = start[:, 1] / np.sqrt(3)
    x[range(count), range(1, count + 1)] = width
    added, noise = np.array(settings.added) * width, np.diag(np.full(4, settings.variance))
    began = time.perf_counter()
    for u, z in zip(inputs, measured, strict=True):
        x[range(count), range(1, count + 1)] += added
        fl, fr, rl, rr, hfl, hfr, hr, hpf, hpr = x @ turned
        across, along = u[4] * u[10] / SIZE.track, u[4] * u[11] / SIZE.wheelbase
        values = np.array(
            [
                fl * u[0] - (fl + fr) * across * hfl - (fl + rl) * along * hpf,
                fr * u[1] + (fl + fr) * across * hfr - (fr + rr) * along * hpf,
                rl * u[2] - (rl + rr) * across * hr + (fl + rl) * along * hpr,
                rr * u[3] + (rl + rr) * across * hr + (fr + rr) * along * hpr,
            ]
        )
        y = values @ chosen.inverse.T
        gain = np.linalg.solve(y[:, 1:] @ y[:, 1:].T + noise, y[:, 1:] @ x[:, 1:].T).T
        x[:, 0] += gain @ (z - y[:, 0])
        x[:, 1:] -= gain @ y[:, 1:]
    return time.perf_counter() - began


def main() -> None:
    """Print a line a model."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 100.0
    rng = np.random.default_rng(0)
    drive = matched_drive(seconds, rng)
    for model in (LTM, MLTM, HFLTM):
        measured = forces(model, drive)
        measured = measured + np.sqrt(10.0) * rng.standard_normal(measured.shape)
        for words, settings in (
            ("the table's", table_settings(model)),
            ("that work", working_settings(model, 10.0)),
        ):
            times = []
            for _ in range(3):
                began = time.perf_counter()
                run = run_filter(model, drive.motion, drive.corners, measured, SIZE, settings, RATE_HZ, rng)
                times.append(time.perf_counter() - began)
            best = min(times)
            line = f"{TITLES[model]:6} settings {words:12} {run.terms:3d} terms {run.points:4d} points {best:6.2f} s"
            if model == HFLTM:
                inputs = inputs_of(drive.motion, drive.corners, SIZE)[:PEER_ROWS]
                peer = peer_seconds(inputs, measured[:PEER_ROWS], settings) * len(measured) / PEER_ROWS
                verdict = "" if best < TARGET_S else f"   above {TARGET_S:g} s"
                line += f"   plain numpy {peer:6.1f} s, ratio {peer / best:.0f}{verdict}"
            print(line)


if __name__ == "__main__":
    main()
