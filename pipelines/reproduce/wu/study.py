"""The paper's set-up over many noise seeds: HEKF-EKF, plain EKF and the companion against the Cramér-Rao bound."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.axle_load_gls.balance import Known, by_speed
from pipelines.estimators.axle_load_gls.data import AxleData
from pipelines.estimators.axle_load_gls.road import Grade
from pipelines.estimators.hekf_ekf.answers import Filtered, widened
from pipelines.filters.hekf import HekfSettings, HekfTrack, hekf_ekf, load_noise_process
from pipelines.models.axle_load import GRAVITY, Noise, bound
from pipelines.reproduce.base import StudyRow, study_row
from pipelines.reproduce.wu.plant import DT, Run, Truck, mixture, mixture_information, mixture_variance
from pipelines.results import FloatArray

SPEED_STD, LOAD_STD = 0.1, 100.0
SHARE = 0.5
START = (0.8, 1.3)
HUBER = 1.345
TARGET = 1.15


@dataclass(frozen=True)
class Case:
    """One set-up, in words: the truth, whether the speed noise is (17) or normal, and all noise as a share of ours."""

    name: str
    run: Run
    contaminated: bool
    noise: float = 1.0


@dataclass(frozen=True)
class Sample:
    """Noisy signals: speed m/s, rear load N."""

    speed: FloatArray
    load: FloatArray


def noisy(case: Case, rng: np.random.Generator) -> Sample:
    """Speed with 0.1 m/s (times (17) where contaminated), load with 100 N."""
    n = len(case.run.speed)
    shape = mixture(n, SHARE, rng) if case.contaminated else rng.standard_normal(n)
    return Sample(
        case.run.speed + case.noise * SPEED_STD * shape,
        case.run.rear + case.noise * LOAD_STD * rng.standard_normal(n),
    )


def speed_variance(case: Case) -> float:
    """Variance of the speed noise, which is the filters' R."""
    return (case.noise * SPEED_STD) ** 2 * (mixture_variance(SHARE) if case.contaminated else 1.0)


def settings(case: Case, sample: Sample, truck: Truck, *, huber: float, weight: float = 0.9) -> HekfSettings:
    """The filter's settings: P0 = diag(.01, .1, .1), Q from the load's noise, start at (v0, 0.8, 1.3)."""
    process = load_noise_process(truck.wheelbase, DT, case.noise * LOAD_STD, truck.mass, START[0])
    start = (float(sample.speed[0]), *START)
    variance = speed_variance(case)
    return HekfSettings(start, (variance, 0.1, 0.1), (process, 0.0, 0.0), variance, huber, weight)


def run_filter(
    case: Case, sample: Sample, truck: Truck, *, huber: float = HUBER, weight: float = 0.9
) -> tuple[HekfTrack, HekfSettings]:
    """The published filter over one sample; huber inf: the plain EKF."""
    chosen = settings(case, sample, truck, huber=huber, weight=weight)
    track = hekf_ekf(
        sample.speed, sample.load, case.run.grade, DT, truck.mass, truck.wheelbase, truck.rolling_arm, chosen
    )
    return track, chosen


def axle_data(case: Case, sample: Sample) -> AxleData:
    """The companion's input."""
    run, n = case.run, len(case.run.speed)
    starts = np.zeros(n)
    starts[0] = 1.0
    return AxleData(
        time_s=run.time_s, rate_hz=1 / DT, load=sample.load, share_front=0.0, share_rear=1.0, front=None,
        rear=float(np.mean(sample.load)), added_std=0.0, accel=None, speed=sample.speed,
        vertical=GRAVITY * np.cos(run.grade), vertical_words="", vertical_leak=0.0, pitch_accel=None, grade=run.grade,
        starts=starts, grade_source=Grade(run.grade, "known", 0.0, "road_grade"), load_words="", speed_words="",
        drive_rows=n, rows=np.arange(n),
    )  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """Height and position with their standard deviations, in m."""

    height: float
    axle: float
    height_std: float
    axle_std: float


def companion(case: Case, sample: Sample, truck: Truck) -> Answer:
    """Generalised least squares with mass, grade and r f exactly known (as the bound has them) and no drag."""
    balance = by_speed(axle_data(case, sample), truck.wheelbase, Known((0.0, 1e-9), (0.0, 1e-9)), HUBER)
    m_h, m_c = balance.moments
    height_std, axle_std = np.sqrt(np.diag(balance.covariance)) / truck.mass
    return Answer(m_h / truck.mass, m_c / truck.mass - truck.rolling_arm, float(height_std), float(axle_std))


def published(case: Case, sample: Sample, truck: Truck, huber: float = HUBER) -> Answer:
    """The end of the filter's run, with the interval that the estimator "hekf_ekf" would widen it to."""
    track, chosen = run_filter(case, sample, truck, huber=huber, weight=0.9 if math.isfinite(huber) else 1.0)
    std = math.sqrt(chosen.speed_variance)
    filtered = Filtered(track, track, chosen, truck.rolling_arm, std, case.noise * LOAD_STD, False)
    own = widened(filtered, axle_data(case, sample))
    return Answer(float(track.height[-1]), float(track.axle[-1]), *own)


def bounds(case: Case, truck: Truck) -> tuple[float, float]:
    """Cramér-Rao bound of height and position, m; for (17) by the mixture's Fisher information."""
    best = SPEED_STD / math.sqrt(mixture_information(SHARE)) if case.contaminated else SPEED_STD
    run = case.run
    return bound(
        run.rear, run.grade, DT, truck.mass, truck.wheelbase, truck.rolling_arm, truck.height, truck.axle,
        Noise(case.noise * best, case.noise * LOAD_STD),
    )  # fmt: skip


def study_case(case: Case, truck: Truck, runs: int, rng: np.random.Generator) -> tuple[StudyRow, ...]:
    """Rows of one set-up: published, plain EKF and companion, height and position."""
    samples = [noisy(case, rng) for _ in range(runs)]
    methods = {
        "HEKF-EKF (published)": [published(case, s, truck) for s in samples],
        "plain EKF": [published(case, s, truck, math.inf) for s in samples],
        "companion (GLS, Huber)": [companion(case, s, truck) for s in samples],
    }
    limits = bounds(case, truck)
    rows = []
    for method, found in methods.items():
        ours = method.startswith("companion")
        for parameter, truth, limit in (
            ("cg_height_m", truck.height, limits[0]),
            ("cg_to_front_axle_m", truck.axle, limits[1]),
        ):
            height = parameter == "cg_height_m"
            value = np.array([a.height if height else a.axle for a in found])
            half = 1.96 * np.array([a.height_std if height else a.axle_std for a in found])
            intervals = np.column_stack((value - half, value + half))
            target = TARGET if ours and height and not case.contaminated else None
            rows.append(study_row(case.name, method, parameter, "m", truth, value, intervals, limit, target))
    return tuple(rows)


def errors_and_times(
    case: Case, truck: Truck, samples: list[Sample]
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Per sample: height and position error at the end (shares), and times (s) after which they stay within 3 and 2 %."""
    result = np.full((4, len(samples)), np.nan)
    for i, sample in enumerate(samples):
        track, _ = run_filter(case, sample, truck)
        for j, (values, truth, limit) in enumerate(
            ((track.height, truck.height, 0.03), (track.axle, truck.axle, 0.02))
        ):
            error = np.abs(values / truth - 1)
            result[j, i] = error[-1]
            outside = np.flatnonzero(error > limit)
            last = -1 if len(outside) == 0 else int(outside[-1])
            # never within for the rest of the run: no time
            result[2 + j, i] = (last + 1) * DT if last + 1 < len(values) else math.inf
    return result[0], result[1], result[2], result[3]
