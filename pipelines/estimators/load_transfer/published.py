"""The published estimators: LTM, MLTM and HFLTM by a gPC-EKF on the strut forces (dissertation, chapters 6-8)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.estimators.load_transfer.answers import (
    GIVEN,
    USUAL_ARM,
    Errors,
    Standing,
    assumptions,
    contradiction,
    level_doubt,
    parameter,
    rolling_shift,
    sensors_covariance,
    softened,
    unknown,
    whole_vehicle,
)
from pipelines.estimators.load_transfer.companion import NEEDS, VEHICLE_NEEDS, value_of
from pipelines.estimators.load_transfer.data import Known, StrutData, collect, known_of, prepare_struts
from pipelines.estimators.load_transfer.figures import force_traces
from pipelines.estimators.load_transfer.filtering import ADDED, NAMES, FilterRun, FilterSettings, run_filter
from pipelines.estimators.load_transfer.kernels import HFLTM, LTM, MLTM
from pipelines.estimators.load_transfer.rough import (
    apart_from_the_whole_drive,
    quick_mass_share,
    roll_inertia_doubt,
)
from pipelines.models.braking import AIR_DENSITY
from pipelines.models.load_transfer import Motion, Size, position
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.results import Assumption, Estimate, FloatArray, ParameterEstimate, Trace, Track
from pipelines.vehicles.usual import STRUT_SCALE, STRUT_ZERO_N
from pipelines.vehicles.vehicle import Vehicle

LEAST_S = 30.0
LEAST_SPREAD = 0.3
WIDTHS = (0.10, 0.06, 0.30)
ROLL_CENTER, CG_HEIGHT, USUAL_TRACK = 0.12, 0.65, 1.6
ROLL_DOUBT, QUICK_DOUBT, PITCH_DOUBT = 0.1, 0.15, 0.2
LUMPED = 0.5
LINKS = 0.04
CALM_S = 10.0
ARMS_HELD = "horizontal force below which the filter holds the arms that it drives"
"""LEAST_S: of moving rows. LEAST_SPREAD: m/s² of horizontal force below which its arm is not given. WIDTHS: half widths of
the first guesses: share of a mass, share of wheelbase or track, m of an arm. ROLL_CENTER, CG_HEIGHT, USUAL_TRACK: m, of which usual
cars make the jacking that the models leave out. …_DOUBT: share of an arm that unsprung masses, wheel spin, tyres and (HFLTM)
the body's lean add to it. LINKS: share of a braking or driving force that links may lift or pull down. CALM_S: of rows below the gate
that masses need to learn from them alone. LUMPED: share of the LTM's misfit of the single struts that may be in its place."""


def _settings(order: float, learning: float, gate: float, gated: str) -> tuple[Setting, ...]:
    return (
        Setting("rate_hz", 200.0, "Hz", "rate at which the filter runs", 20.0, 1000.0),
        Setting("cutoff_hz", 20.0, "Hz", "zero-phase low-pass of all signals", 1.0, 200.0),
        Setting("order", order, "", "polynomial order of the expansion (the tables: 1)", 1.0, 2.0),
        Setting("points_per_term", 4.0, "", "collocation points per term (the tables: 1)", 1.0, 8.0),
        Setting("square_root", 0.0, "", "0: update as published (40), which collapses; 1: keeps the spread", 0.0, 1.0),
        Setting("force_std", 100.0, "N", "R: model error and noise of a strut force (the tables: 3.2)", 1.0, 5000.0),
        Setting("learning", learning, "", "factor on the tables' c of the arms", 0.0, 1e5),
        Setting("gate_g", gate, "g", gated, 0.0, 1.0),
        Setting("force_scale_std", STRUT_SCALE, "share", "scale error of a strut force sensor", 0.0, 0.5),
        Setting("force_offset_std", STRUT_ZERO_N, "N", "offset of a strut force sensor", 0.0, 5000.0),
    )  # fmt: skip


def motion_of(data: StrutData) -> Motion:
    """The road plane's motion from the leaning body's: its standing lean is in the offsets already."""
    speed = np.zeros(data.size) if data.speed is None else data.speed
    roll, pitch = data.roll - data.roll.mean(), data.pitch - data.pitch.mean()
    return Motion(
        data.along + GRAVITY * pitch, data.across - GRAVITY * roll, data.vertical, roll, pitch, speed
    )


def first_guess(model: int, data: StrutData, size: Size) -> tuple[tuple[float, float], ...]:
    """First guesses and half widths, from the first second's forces: (114), (134), (142) are those of one vehicle."""
    loads = data.forces[: max(1, int(data.rate_hz))].mean(axis=0) / GRAVITY
    loads = np.maximum(loads, 0.02 * max(float(loads.sum()), 100.0))
    heavy, place, arm = WIDTHS
    arms = (USUAL_ARM, arm)
    if model == LTM:
        total, behind, left = position(loads, size)
        spans = ((behind, place * size.wheelbase), (left, place * size.track))
        return ((total, heavy * total), *spans, arms, arms, (0.5, 0.3))
    masses = tuple((float(m), heavy * float(m)) for m in loads)
    return (*masses, arms, arms, (0.5, 0.3)) if model == MLTM else (*masses, *(arms,) * 5)


@dataclass(frozen=True)
class _Filtered:
    """A run with the static strut loads that it ends at, (4,), their path over the second half (k, 4), and its misfit."""

    run: FilterRun
    data: StrutData
    loads: FloatArray
    path: FloatArray
    misfit: FloatArray


def _static_loads(model: int, track: FloatArray, size: Size) -> FloatArray:
    """(k, 4) weight over each strut along a track."""
    if model != LTM:
        return np.asarray(track[:, :4] * GRAVITY)
    front, left = 1 - track[:, 1] / size.wheelbase, 1 - track[:, 2] / size.track
    shares = (front * left, front * (1 - left), (1 - front) * left, (1 - front) * (1 - left))
    return np.asarray(np.column_stack(shares) * (track[:, :1] * GRAVITY))


def _filter(
    model: int, data: StrutData, known: Known, settings: FilterSettings, rng: np.random.Generator
) -> _Filtered:
    run = run_filter(
        model, motion_of(data), data.corners, data.forces, known.size, settings, data.rate_hz, rng
    )
    loads = _static_loads(model, run.track, known.size)
    late = slice(len(run.predicted) // 2, None)
    misfit = (data.forces - run.predicted[:, :4])[late].mean(axis=0)
    return _Filtered(run, data, loads[-1], loads[len(loads) // 2 :], misfit)


def calm_limit(model: int, data: StrutData, gate: float) -> float:
    """[g] of lateral force above which the MLTM holds its masses: the links carry weight in turns, which no load transfer model has.

    inf: never. So it is for the others, without a gate, and where less than `CALM_S` of the drive is below it.
    """
    if model != MLTM or gate <= 0:
        return math.inf
    calm = float(np.sum(np.abs(data.across) < GRAVITY * gate)) / data.rate_hz
    return gate if calm >= CALM_S else math.inf


def jacking_share(across: FloatArray, known: Known, vehicle: Vehicle) -> float:
    """Share of the weight that the links carry in the mean of these turns: 4 h_rc h A_y² / (g B)²; A_y in m/s²."""
    centers = [vehicle.get(f"roll_center_height_{axle}_m") for axle in ("front", "rear")]
    center = float(np.mean([ROLL_CENTER if c is None else abs(c.value) + c.std for c in centers]))
    height = CG_HEIGHT / USUAL_TRACK * known.size.track
    return 4 * center * height * float(np.mean(across**2)) / (GRAVITY * known.size.track) ** 2


def _standing(
    model: int, found: _Filtered, known: Known, errors: Errors, vehicle: Vehicle, calm: float
) -> Standing:
    """Loads with what a filter's own covariance leaves out: its wandering, jacking, misfit, sensors, offsets.

    calm: [g] of lateral force below which it learned its masses.
    """
    loads, data = found.loads, found.data
    heard = np.abs(data.across) <= GRAVITY * calm
    wander = np.cov(found.path.T) if len(found.path) > 2 else np.diag((0.05 * loads) ** 2)
    jacking = 1.2 * jacking_share(data.across[heard], known, vehicle)
    links = LINKS * float(np.mean(np.abs(data.along[heard]))) / GRAVITY
    covariance = wander + sensors_covariance(loads, errors) + np.diag(found.misfit**2)
    quick = quick_mass_share(data, loads) if model == HFLTM else 0.0
    covariance = covariance + (jacking**2 + links**2 + quick**2 + 0.004**2) * np.outer(loads, loads)
    along, across = level_doubt(data, (USUAL_ARM, USUAL_ARM))
    lumped = LUMPED * np.abs(found.misfit).mean() / loads.mean() if model == LTM else 0.0
    length = known.wheelbase.value
    # as the companion has it: what rolling resistance moves to the rear axle no scale shows
    rolled, rolled_std = rolling_shift(vehicle, known)
    shift = math.hypot(
        along, rolled_std, 0.004, 0.5 * jacking * length, 0.5 * links * length, lumped * length
    )
    aside = math.hypot(across, 0.002, 0.3 * jacking * known.size.track, lumped * known.size.track)
    return Standing(loads, covariance, (rolled, shift), (0.0, aside))


class _Published:
    """What the three estimators share."""

    name: str
    title: str
    source: str
    settings: tuple[Setting, ...]
    model: int
    signal_needs: tuple[Need, ...] = NEEDS
    vehicle_needs: tuple[Need, ...] = VEHICLE_NEEDS
    parameters: tuple[str, ...] = GIVEN

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Strut forces with everything beside them on one clock."""
        return prepare_struts(drive, self._set(settings, "rate_hz"), self._set(settings, "cutoff_hz"))

    def _set(self, settings: Settings, name: str) -> float:
        return value_of(settings, self.settings, name)

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Run the filter over the drive; its figures at the end, with an interval that is wider than its own."""
        known = known_of(vehicle)
        data = None if known is None else collect(prepared, known)
        if data is None or known is None:
            return self._nothing(
                "; ".join(prepared.notes) or "no stretch holds all four suspension forces", vehicle
            )
        if not data.moving or data.size < LEAST_S * data.rate_hz:
            return self._nothing(f"the filter needs {LEAST_S:g} s of driving", vehicle)
        run = self._filter_settings(settings, data, known)
        found = _filter(self.model, data, known, run, rng)
        errors = Errors(self._set(settings, "force_scale_std"), self._set(settings, "force_offset_std"))
        if not np.isfinite(found.run.track[-1]).all():
            return self._nothing("the filter diverged", vehicle)
        standing = _standing(self.model, found, known, errors, vehicle, run.calm)
        wrong = contradiction(standing, data, vehicle)
        if wrong is not None:
            return self._nothing(wrong, vehicle)
        parameters = self._parameters(found, standing, known, vehicle, errors)
        return Estimate(
            self.name, "ran", "the filter ran over the drive", parameters,
            tracks=self._tracks(found, known, parameters),
            traces=(*force_traces(self.name, data, prepared, found.run.predicted[:, :4], "one step ahead, before each update"),
                    *_arm_traces(self.name, found)),
            assumptions=(*assumptions(data, known, errors), Assumption(
                "filter", f"order {run.order}, {found.run.terms} terms, {found.run.points} points, R = {run.variance:.0f} N²",
                "settings")),
            diagnostics=_figures(found), used_fraction=data.size / max(data.drive_rows, 1), witness=True,
        )  # fmt: skip

    def _filter_settings(self, settings: Settings, data: StrutData, known: Known) -> FilterSettings:
        learning, variance = self._set(settings, "learning"), self._set(settings, "force_std") ** 2
        added = tuple(
            c * (learning if name.startswith("h_") else 1.0)
            for name, c in zip(NAMES[self.model], ADDED[self.model], strict=True)
        )
        gate = self._set(settings, "gate_g")
        # the tables' R is that of a step of 1 ms, ours that of a step of the filter
        variance *= 1000.0 / data.rate_hz
        return FilterSettings(
            round(self._set(settings, "order")), self._set(settings, "points_per_term"),
            round(self._set(settings, "square_root")), variance, 4 * variance, added,
            first_guess(self.model, data, known.size), gate, calm_limit(self.model, data, gate),
        )  # fmt: skip

    def _parameters(
        self, found: _Filtered, standing: Standing, known: Known, vehicle: Vehicle, errors: Errors
    ) -> dict[str, ParameterEstimate]:
        words = "end of the filter's run on strut forces, and the vehicle file's unsprung masses"
        answers = {
            n: parameter(n, value, std, words, known, vehicle, self.name)
            for n, (value, std) in whole_vehicle(standing, known).items()
        }
        data, run = found.data, found.run
        if self.model == HFLTM:
            answers |= self._beside_the_batch(answers, standing, found, errors)
        for name, arm, force in (("roll_arm_m", "h_r", data.across), ("pitch_arm_m", "h_p", data.along)):
            if float(np.std(force)) < LEAST_SPREAD:
                answers[name] = unknown(name, "the drive hardly corners or brakes", vehicle)
                continue
            value, std = _arm(run, arm, self.model)
            doubt = PITCH_DOUBT if arm == "h_p" else QUICK_DOUBT if self.model == HFLTM else ROLL_DOUBT
            # an arm that the filter left too short is no surer for it
            std = math.hypot(std, doubt * max(value, USUAL_ARM))
            if arm == "h_r" and self.model == LTM:
                std = math.hypot(
                    std,
                    roll_inertia_doubt(
                        data, motion_of(data).accel_y, max(value, USUAL_ARM), known.size.track
                    ),
                )
            why = (
                "mean of the arms over the second half of the run"
                if self.model == HFLTM
                else "end of the run"
            )
            answers[name] = softened(parameter(name, value, std, why, known, vehicle, self.name))
        if self.model == HFLTM:
            why = "the HFLTM leaves drag to its quick arms"
        else:
            why = (
                f"the filter ends at {2 * float(run.track[-1, -1]) / AIR_DENSITY:.2f} m², but in h_p C V² every offset and grade passes for "
                "drag: load_transfer_batch sets them free"
            )
        answers["drag_area_m2"] = unknown("drag_area_m2", why, vehicle)
        return answers

    @staticmethod
    def _beside_the_batch(
        answers: dict[str, ParameterEstimate], standing: Standing, found: _Filtered, errors: Errors
    ) -> dict[str, ParameterEstimate]:
        """The masses, weak where the filter's contradicts the balance over the whole drive."""
        total = float(standing.loads.sum())
        # the sensors' errors are in both
        own = standing.covariance - sensors_covariance(standing.loads, errors)
        share = math.sqrt(max(float(own.sum()), 0.0)) / total
        words = apart_from_the_whole_drive(found.data, total, share)
        if words is None:
            return {}
        weak = {n: softened(answers[n]) for n in ("mass_kg", "sprung_mass_kg")}
        return {n: replace(entry, reason=f"{words}; {entry.reason}") for n, entry in weak.items()}

    def _tracks(
        self, found: _Filtered, known: Known, parameters: dict[str, ParameterEstimate]
    ) -> tuple[Track, ...]:
        loads = _static_loads(self.model, found.run.track, known.size)
        sprung = loads.sum(axis=1) / GRAVITY
        values = {"mass_kg": sprung + known.unsprung_kg, "sprung_mass_kg": sprung}
        time_s = found.data.time_s[found.run.at]
        tracks = []
        for name, value in values.items():
            entry = parameters[name]
            if entry.std is not None:
                half = 1.96 * entry.std
                tracks.append(Track(name, time_s, value, value - half, value + half))
        return tuple(tracks)

    def _nothing(self, reason: str, vehicle: Vehicle) -> Estimate:
        return Estimate(
            self.name, "ran", reason, {n: unknown(n, reason, vehicle) for n in GIVEN}, witness=True
        )


def _arm(run: FilterRun, arm: str, model: int) -> tuple[float, float]:
    """An arm and how much it wanders."""
    columns = [i for i, n in enumerate(run.names) if n.startswith(arm)]
    late = run.track[len(run.track) // 2 :, columns]
    value = float(late.mean()) if model == HFLTM else float(run.track[-1, columns[0]])
    return value, float(late.std())


def _arm_traces(name: str, found: _Filtered) -> tuple[Trace, ...]:
    """Roll and pitch arms over the drive."""
    run = found.run
    columns = {n: run.track[:, i] for i, n in enumerate(run.names) if n.startswith("h_")}
    return (
        Trace(
            f"{name}: arms",
            found.data.time_s[run.at],
            columns,
            dict.fromkeys(columns, "m"),
            "CG above roll and pitch centres",
        ),
    )


def _figures(found: _Filtered) -> dict[str, float]:
    run, data = found.run, found.data
    error = (data.forces - run.predicted[:, :4])[len(data.forces) // 10 :]
    figures = {f"one_step_rms_{w}_n": float(np.sqrt(np.mean(error[:, i] ** 2))) for i, w in enumerate(WHEELS)}
    figures |= {f"late_mean_error_{w}_n": float(m) for w, m in zip(WHEELS, found.misfit, strict=True)}
    figures |= {f"end_{n}": float(v) for n, v in zip(run.names, run.track[-1], strict=True)}
    return figures | {"one_step_peak_n": float(np.abs(error).max()), "terms": float(run.terms)}


class LoadTransfer(_Published):
    """The estimator "load_transfer"."""

    name = "load_transfer"
    title = "Load transfer model (LTM), gPC-EKF"
    source = "gPC dissertation, chapter 6, (106)-(116), Table 6.1 with order 2 and four points a term"
    settings = _settings(2.0, 1.0, 0.0, f"{ARMS_HELD} (published: 0, no gate)")
    model = LTM


class ModifiedLoadTransfer(_Published):
    """The estimator "modified_load_transfer"."""

    name = "modified_load_transfer"
    title = "Modified load transfer model (MLTM), gPC-EKF"
    source = "gPC dissertation, chapter 7, (117)-(136), Table 7.1 with order 2 and four points a term"
    settings = _settings(
        2.0,
        1.0,
        0.1,
        f"{ARMS_HELD}; and lateral force above which it holds its masses (published: 0, no gate)",
    )
    model = MLTM


class HighFrequencyLoadTransfer(_Published):
    """The estimator "high_frequency_load_transfer"."""

    name = "high_frequency_load_transfer"
    title = "High-frequency load transfer model (HFLTM), gPC-EKF"
    source = "gPC dissertation, chapter 8, (137)-(145), Table 8.1 with four points a term and quicker arms"
    settings = _settings(1.0, 100.0, 0.1, f"{ARMS_HELD} (8.2)")
    model = HFLTM
