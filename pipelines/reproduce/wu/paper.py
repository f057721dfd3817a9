"""`cogest reproduce wu`: Wu et al.'s table, figures and claims beside ours, and the study against the bound."""

from __future__ import annotations

import numpy as np

from pipelines.models.axle_load import Noise, bound
from pipelines.reproduce.base import Claim, Progress, ReproducedTable, Reproduction, StudyRow
from pipelines.reproduce.wu.claims import claims_of
from pipelines.reproduce.wu.datasheet import study_data_sheet
from pipelines.reproduce.wu.plant import DT, Truck, drive
from pipelines.reproduce.wu.study import LOAD_STD, SPEED_STD, Case, study_case
from pipelines.reproduce.wu.tables import CaseResult, cases_table, driving_case, steps, table_one
from pipelines.reproduce.wu.weighting import weighting_table
from pipelines.results import Trace

CASES: tuple[tuple[str, bool, bool], ...] = (
    ("4WD, flat", False, False), ("4WD, slope", False, True), ("RWD, flat", True, False), ("RWD, slope", True, True),
)  # fmt: skip
CASE_RUNS = 40
QUICK = 4
"""The study on the exact set-up takes four times as many seeds: a run costs milliseconds, and the ratio to the bound
would be uncertain by a tenth with 50."""


class Wu:
    """The paper "wu"."""

    name: str = "wu"
    title: str = "CG height and position from rear axle load and speed by HEKF-EKF"

    def reproduce(self, runs: int, rng: np.random.Generator, progress: Progress) -> Reproduction:
        """All of it; deterministic for a given generator."""
        truck = Truck()
        progress("Table 1", 0.0)
        first, plain, robust = table_one(rng)
        results: list[CaseResult] = []
        for number, (name, rear, slope) in enumerate(CASES):
            progress(f"driving case {name}", 0.05 + 0.1 * number)
            results.append(driving_case(name, rear, slope, truck, max(5, min(runs, CASE_RUNS)), rng))
        rows: list[StudyRow] = []
        for number, (slope, dirty) in enumerate(((False, False), (True, False), (False, True), (True, True))):
            words = f"{'slope' if slope else 'flat'}, {'half of the speed noise by (17)' if dirty else 'normal noise'}"
            progress(f"study: {words}", 0.5 + 0.1 * number)
            run = drive(truck, rear_wheel_drive=False, slope=slope, rich=False)
            rows += study_case(Case(words, run, dirty), truck, QUICK * runs, rng)
        progress("study: data-sheet knowledge", 0.9)
        for slope in (False, True):
            run = drive(truck, rear_wheel_drive=True, slope=slope, rich=True)
            words = f"{'slope' if slope else 'flat'}, richer plant, data-sheet knowledge"
            rows += study_data_sheet(Case(words, run, False), truck, runs, rng)
        claims = claims_of(results, plain, robust, truck, self._at_two_seconds(truck), rng)
        progress("done", 1.0)
        return self._page(
            truck, (first, cases_table(results, truck), weighting_table(truck, rng)), claims, rows, results
        )

    @staticmethod
    def _at_two_seconds(truck: Truck) -> tuple[float, float]:
        """The bound of the height after 2 s (share): with our noise, and with a tenth of it."""
        run = drive(truck, rear_wheel_drive=False, slope=False, rich=False)
        n = steps(2.0) + 1
        found = [
            bound(
                run.rear[:n], run.grade[:n], DT, truck.mass, truck.wheelbase, truck.rolling_arm, truck.height,
                truck.axle, Noise(SPEED_STD * part, LOAD_STD * part),
            )[0] / truck.height
            for part in (1.0, 0.1)
        ]  # fmt: skip
        return found[0], found[1]

    def _page(
        self, truck: Truck, tables: tuple[ReproducedTable, ...], claims: tuple[Claim, ...], rows: list[StudyRow], results: list[CaseResult],
    ) -> Reproduction:  # fmt: skip
        time_s = np.asarray(np.arange(len(results[0].weighted)) * DT, dtype=np.float64)
        traces = []
        for what, unit, truth in (("height", "m", truck.height), ("distance to front axle", "m", truck.axle)):
            columns = {r.name: r.weighted if what == "height" else r.position for r in results}
            columns["truth"] = np.full(len(time_s), truth)
            traces.append(
                Trace(
                    f"wu: {what}", time_s, columns, dict.fromkeys(columns, unit), "HEKF-EKF, one run a case"
                )
            )
        slip = results[0].slip, results[2].slip
        baseline = {
            "4WD, flat": slip[0].height,
            "RWD, flat": slip[1].height,
            "truth": np.full(len(time_s), truck.height),
        }
        traces.append(
            Trace(
                "wu: height by the slip baseline",
                time_s,
                baseline,
                dict.fromkeys(baseline, "m"),
                "equal slip stiffness",
            )
        )
        setup = (
            f"Truck of Table 2 ({truck.mass:g} kg, h {truck.height:g} m, a {truck.axle:g} m, L {truck.wheelbase:g} m), own plant "
            "with slipping wheels (magic formula, friction 0.85), 25 s from 15 km/h, three accelerations and two decelerations "
            "between -1.7 and 2.1 m/s²; hill of 8 m, at most 6 degrees.",
            f"Speed with {SPEED_STD:g} m/s, rear axle load with {LOAD_STD:g} N of noise at 50 Hz; contaminated: the speed noise "
            "is 0.1 m/s times (17) with epsilon 0.5.",
            "Mass, wheelbase, rolling resistance and grade exactly known, as the paper has them (the last study rows: not).",
            "Bound: numerical Cramér-Rao bound, starting speed unknown, load noise as a random walk of the speed; under (17) "
            "with the mixture's Fisher information.",
        )
        notes = (
            "In (6) alpha is theta. (19) repeats (17): the equivalent acceleration's formula is missing; we took "
            "|a_x + g sin(theta) + F_a/m|. Table 3 has six states and belongs to another filter (its title says EKF/UKF). "
            "The step is 0.02 s in the text and 0.01 s in Table 3; we took 0.02 s.",
            "Only m a + m r f and m h follow from axle load and speed: a mass wrong by 2 % moves both answers by 2 %.",
            "The filter's own covariance gives its height far too narrow an interval once the model is not exact: the estimator "
            "widens it by residual correlation, the estimate's wandering, and the parts that (1)-(2) leave out.",
        )
        return Reproduction(
            self.name, self.title,
            "F. Wu, C. Sun, H. Li, S. Zheng: Real-Time Center of Gravity Estimation for Intelligent Connected Vehicle Based on "
            "HEKF-EKF. Electronics 12 (2023) 386",
            setup, tables, claims, tuple(rows), tuple(traces), (), notes,
        )  # fmt: skip
