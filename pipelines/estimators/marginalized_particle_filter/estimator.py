"""CG height, roll stiffness and damping by Berntorp et al.'s marginalised particle filter."""

from __future__ import annotations

import numpy as np

from parsers.channels import IntArray
from parsers.drive import Drive
from pipelines.estimators.base import (
    FullSettings,
    Need,
    PriorEntry,
    PriorError,
    Setting,
    Settings,
    TextSetting,
)
from pipelines.estimators.marginalized_particle_filter.answers import (
    GIVEN,
    NAME,
    answers,
    distributions,
    not_told,
    over_the_drive,
    tracks,
)
from pipelines.estimators.marginalized_particle_filter.coefficients import inflation, pooled
from pipelines.estimators.marginalized_particle_filter.figures import assumptions, figures, traces
from pipelines.estimators.marginalized_particle_filter.inputs import inputs_of
from pipelines.estimators.marginalized_particle_filter.run import Clouds, given_of, run_clouds
from pipelines.estimators.roll_map.data import RollData, collect
from pipelines.estimators.roll_map.estimator import LEAST_EXPLAINED, LEAST_STIFFNESS, RollMap
from pipelines.estimators.roll_map.vehicle import VehiclePart, before_the_log
from pipelines.estimators.roll_map.words import said_of_drive
from pipelines.models.roll import DEGREES, GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.roll_angle import RollSource, rank_roll
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Vehicle
from pipelines.warm_start.warm_start import NothingFitsError

DRAWS = 40_000
NO_MODEL = (
    "no stiffness, damping and height make a roll model that does not run away, of what is stated of the vehicle and of where "
    "the accelerometer sits (far above the CG there is none)"
)

SNAPSHOTS = 40

SETTINGS: tuple[Setting, ...] = (
    Setting("particles", 500, "particles", "wanted effective particles N* of a cloud (published: 1 000 in one cloud); "
            "of the kernel variant, its particles", 50, 20_000),
    Setting("most_particles", 8000, "particles", "cap on the number of particles, whatever is wanted or adaptation asks for", 100, 50_000),
    Setting("clouds", 4, "clouds", "independent clouds on the same data: their spread makes the interval honest", 2, 16),
    Setting("max_rows", 12_000, "samples", "most samples that are filtered; the liveliest stretches are taken", 500, 200_000),
    Setting("cutoff_hz", 8.0, "Hz", "zero-phase low-pass of all signals", 2.0, 40.0),
    Setting("least_excitation", 0.5, "m/s²", "lateral acceleration (RMS over 6 s) from which a stretch is used", 0.0, 5.0),
    Setting("least_spread", 0.5, "m/s²", "spread of lateral acceleration below which nothing is estimated", 0.0, 5.0),
)  # fmt: skip
TEXT_SETTINGS: tuple[TextSetting, ...] = (
    TextSetting(
        "variant",
        "published",
        ("published", "nonbo", "nonadap", "kernel"),
        "published: resampling at every sample, a random walk of the parameters; nonbo: the same from the whole box, without Bayesian "
        "optimisation; nonadap: the same with `particles` particles throughout; kernel: resampling below half the particles, Liu "
        "and West's move, no random walk, sensor offsets as states",
    ),
)


def _value(settings: Settings, name: str) -> float:
    default = next(s.default for s in SETTINGS if s.name == name)
    return float(settings.get(name, default))


def _variant(settings: Settings) -> str:
    texts = settings.texts if isinstance(settings, FullSettings) else {}
    return texts.get("variant", TEXT_SETTINGS[0].default)


class MarginalizedParticleFilter:
    """The estimator "marginalized_particle_filter"."""

    name: str = NAME
    title: str = "Marginalised particle filter on roll (Berntorp et al.)"

    source: str = (
        "Berntorp, Chakrabarty, Di Cairano: Vehicle center-of-gravity height and dynamics estimation with uncertainty "
        "quantification by marginalized particle filter, Algorithms 1 and 2, eqs. (1)-(10)"
    )

    @property
    def signal_needs(self) -> tuple[Need, ...]:
        """Lateral acceleration and something that sees roll."""
        return RollMap().signal_needs

    vehicle_needs: tuple[Need, ...] = (
        Need(("mass_kg",), "the motion tells only ratios to the mass: it must be given"),
    )
    parameters: tuple[str, ...] = GIVEN
    settings: tuple[Setting, ...] = SETTINGS
    text_settings: tuple[TextSetting, ...] = TEXT_SETTINGS

    def check_priors(self, texts: dict[str, str], priors: dict[str, PriorEntry]) -> None:
        """It takes its priors from the vehicle file alone. Raises PriorError."""
        for name in priors:
            raise PriorError(
                name, "the particle filter takes no priors from settings", "give them in the vehicle file"
            )

    def configured(self, settings: Settings) -> MarginalizedParticleFilter:
        """The same whatever the settings."""
        return self

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """As `roll_map`: lateral acceleration and the roll channels on one clock."""
        return RollMap().prepare(drive, {"cutoff_hz": _value(settings, "cutoff_hz")})

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Warm start, clouds, and what they mean. A drive that cannot tell ends "not_identifiable" with the reason."""
        ranked = rank_roll(prepared, vehicle) if prepared.segments else ()
        roll = ranked[0] if ranked else None
        data = None
        if prepared.segments and (roll is not None or "roll_rate" in prepared.columns):
            least, most = _value(settings, "least_excitation"), round(_value(settings, "max_rows"))
            data = collect(prepared, roll, least, most)
        before = before_the_log(vehicle, rng, DRAWS)
        spread = 0.0 if data is None else float(np.std(data.accel))
        seen = data is not None and (data.has_roll or data.has_rate)
        if before.draws is None:
            return self._nothing(before, vehicle, data, "the vehicle's mass is not known: give mass_kg")
        if data is None or not seen or spread < _value(settings, "least_spread"):
            return self._nothing(before, vehicle, data, said_of_drive(prepared, data, spread))
        inputs = inputs_of(data, prepared)
        if not np.isfinite(inputs.y).any():
            return self._nothing(before, vehicle, data, "no roll signal is there while the vehicle corners")
        rows = np.unique(np.linspace(0, data.size - 1, SNAPSHOTS + 1).round().astype(np.int64))[1:]
        try:
            clouds = run_clouds(
                inputs, given_of(before.draws), _variant(settings), round(_value(settings, "particles")),
                round(_value(settings, "most_particles")), round(_value(settings, "clouds")), rows, rng,
            )  # fmt: skip
        except NothingFitsError:
            return self._nothing(before, vehicle, data, NO_MODEL)
        return self._explain(prepared, data, clouds, roll, vehicle, before, rows, rng)

    def _explain(
        self,
        prepared: Prepared,
        data: RollData,
        clouds: Clouds,
        roll: RollSource | None,
        vehicle: Vehicle,
        before: VehiclePart,
        rows: IntArray,
        rng: np.random.Generator,
    ) -> Estimate:
        """Parameters, distributions and words of the clouds."""
        inputs = inputs_of(data, prepared)
        if clouds.explained < LEAST_EXPLAINED:
            share = max(0.0, 100 * clouds.explained)
            why = f"the roll motion does not follow the lateral acceleration ({share:.0f} % of it does): the road banks into its bends, or the channel or its sign is another"
            return self._nothing(before, vehicle, data, why)
        mean, covariance = pooled([run.final for run in clouds.runs])
        if mean[0] < LEAST_STIFFNESS:
            gradient = GRAVITY * DEGREES / max(float(mean[0]), 1e-3)
            why = f"the roll angle goes with the acceleration as on tilting ground ({gradient:.0f} deg/g): it does not show the suspension"
            return self._nothing(before, vehicle, data, why)
        scale_std = 0.005 if roll is None or not data.has_roll else max(roll.scale_std, 0.003)
        over, coefficients = over_the_drive(clouds, data, inputs, scale_std)
        parameters, second, sentences = answers(before, coefficients, data, vehicle, rng)
        seen_s = prepared.time_s[data.rows[over.rows.astype(np.int64)]]
        found = distributions(over, before, data, seen_s, rng)
        depleted = sum(run.depleted for run in clouds.runs)
        if depleted:
            sentences = (
                *sentences,
                f"{depleted} of {len(clouds.runs)} clouds ran short of particles on the way.",
            )
        return Estimate(
            estimator=self.name,
            status="ran",
            reason=" ".join(("the filter ran over the excited stretches.", *sentences)),
            parameters=parameters,
            tracks=tracks(found),
            traces=traces(clouds, data, prepared, inputs),
            assumptions=(*assumptions(clouds, data, roll, inputs), *before.assumptions),
            diagnostics={
                **figures(clouds, coefficients, covariance, inflation(clouds, inputs.step_s)),
                **second,
            },
            used_fraction=data.size / max(data.drive_rows, 1),
            witness=True,
            distributions=found,
        )

    def _nothing(self, before: VehiclePart, vehicle: Vehicle, data: RollData | None, reason: str) -> Estimate:
        """The answer of a drive that cannot tell."""
        used = 0.0 if data is None else data.size / max(data.drive_rows, 1)
        return Estimate(
            self.name, "ran", reason, not_told(before, reason, vehicle.reference), assumptions=before.assumptions,
            used_fraction=used, witness=True,
        )  # fmt: skip
