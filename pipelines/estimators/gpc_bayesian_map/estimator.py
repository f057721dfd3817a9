"""gPC-Bayesian MAP estimation (the dissertation, 3.3 and 5.1) of any model of the registry; published, hence a witness.

The model's residuals are expanded in orthonormal polynomials over the prior's support; the posterior of an interval is the
prior of the next, and the support follows it (pipelines/bayes). The settings file names the model and its priors.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.drive import Drive
from parsers.errors import ExpansionError
from pipelines.bayes.priors import Priors
from pipelines.bayes.sequence import Choice
from pipelines.estimators.base import (
    FullSettings,
    Need,
    PriorEntry,
    Setting,
    Settings,
    TextSetting,
)
from pipelines.estimators.gpc_bayesian_map.answers import answer, nothing, own_figures, spread, told
from pipelines.estimators.gpc_bayesian_map.body import (
    MOST_STIFFER,
    Figure,
    stiffened,
    stiffening,
    travel,
    travel_error,
    whole_vehicle,
)
from pipelines.estimators.gpc_bayesian_map.chosen import check_priors, priors_of
from pipelines.estimators.gpc_bayesian_map.data import ModelData, collect
from pipelines.estimators.gpc_bayesian_map.figures import densities, traces, tracks
from pipelines.estimators.gpc_bayesian_map.fit import Fit, fit
from pipelines.models import registry
from pipelines.models.record import Model
from pipelines.models.registry import model
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.signals import prepare_signals
from pipelines.results import Assumption, Estimate
from pipelines.vehicles.vehicle import Quantity, Vehicle

DEFAULT_MODEL = "base_excitation_3dof"
BODY_PARAMETERS = (
    "sprung_mass_kg",
    "mass_kg",
    "pitch_inertia_kgm2",
    "roll_inertia_kgm2",
    "cg_to_front_axle_m",
)

SETTINGS: tuple[Setting, ...] = (
    Setting("cutoff_hz", 0.0, "Hz", "zero-phase low-pass of all signals; 0 = the model's own", 0.0, 500.0),
    Setting("band_low_hz", 0.0, "Hz", "lowest frequency that is fitted; 0 = the model's own", 0.0, 50.0),
    Setting("band_high_hz", 0.0, "Hz", "highest frequency that is fitted; 0 = the model's own", 0.0, 200.0),
    Setting("block_s", 5.0, "s", "length of the blocks that the drive is cut into", 1.0, 120.0),
    Setting("most_blocks", 60.0, "", "the liveliest so many blocks are used", 3.0, 2000.0),
    Setting("intervals", 6.0, "", "sequential intervals: the posterior of one is the prior of the next", 1.0, 500.0),
    Setting("order", 3.0, "", "order of the expansion over the prior's support", 1.0, 12.0),
    Setting("near_order", 2.0, "", "order of the expansion over a posterior's surroundings", 1.0, 8.0),
    Setting("points_per_term", 3.0, "", "collocation points for each term of an expansion", 1.5, 20.0),
    Setting("model_error_scale", 1.0, "", "factor on what the model leaves out (0 on a simulation of the model itself)", 0.0, 10.0),
)  # fmt: skip
DEFAULTS = {s.name: s.default for s in SETTINGS}
UNTOLD_ERROR = 1.0
"""Error of a log likelihood over the posterior beyond which its width is anyone's guess."""


@dataclass(frozen=True)
class GpcBayesianMap:
    """The estimator "gpc_bayesian_map", with the needs and parameters of one model."""

    model_name: str = DEFAULT_MODEL

    name: str = "gpc_bayesian_map"
    title: str = "gPC-Bayesian MAP estimation of a chosen model"
    source: str = "dissertation, 3.3, equations (43)-(48): residuals by collocation, sequential intervals; by default 5.1, (86)-(100)"
    settings: tuple[Setting, ...] = SETTINGS

    @property
    def text_settings(self) -> tuple[TextSetting, ...]:
        """The model's name."""
        meaning = "the model whose parameters are estimated"
        return (TextSetting("model", DEFAULT_MODEL, tuple(registry.MODELS), meaning),)

    @property
    def model(self) -> Model:
        """The record of the chosen model."""
        return model(self.model_name)

    @property
    def whole_body(self) -> bool:
        """Whether the model's parameters are turned into those of the whole vehicle."""
        return self.model_name == DEFAULT_MODEL

    @property
    def signal_needs(self) -> tuple[Need, ...]:
        """Every signal of the model."""
        inputs = tuple(Need((n,), "an input of the model") for n in self.model.inputs)
        return inputs + tuple(Need((n,), "what the model predicts") for n in self.model.outputs)

    @property
    def vehicle_needs(self) -> tuple[Need, ...]:
        """Figures without a default."""
        return tuple(Need((g.key,), g.why) for g in self.model.given if g.default is None)

    @property
    def parameters(self) -> tuple[str, ...]:
        """What it gives."""
        return BODY_PARAMETERS if self.whole_body else told(self.model)

    def check_priors(self, texts: Mapping[str, str], priors: Mapping[str, PriorEntry]) -> None:
        """Raise PriorError for a prior that the named model cannot take."""
        check_priors(model(texts["model"]), priors)

    def configured(self, settings: Settings) -> GpcBayesianMap:
        """With the settings' model."""
        if isinstance(settings, FullSettings):
            return GpcBayesianMap(settings.texts.get("model", DEFAULT_MODEL))
        return self

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """The model's signals on one clock, low-passed alike."""
        chosen = self.model
        cutoff = settings.get("cutoff_hz", 0.0) or chosen.cutoff_hz
        return prepare_signals(drive, [*chosen.inputs, *chosen.outputs], rate_hz=None, cutoff_hz=cutoff)

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Estimate. A drive that cannot tell ends with parameters "not_identifiable" and the reason."""
        full = {**DEFAULTS, **settings}
        written = settings.priors if isinstance(settings, FullSettings) else {}
        chosen = self.model
        priors = priors_of(chosen, vehicle, written)
        data = collect(
            prepared,
            chosen,
            band_hz=(
                full["band_low_hz"] or chosen.band_hz[0],
                min(full["band_high_hz"] or chosen.band_hz[1], 0.8 * max(prepared.cutoff_hz, 1e-6)),
            ),
            block_s=full["block_s"],
            intervals=round(full["intervals"]),
            least_input=chosen.least_input,
            most_blocks=round(full["most_blocks"]),
        )
        figures, why = chosen.figures(vehicle), data.why_not
        if self.whole_body and not why:
            more = stiffening(figures, vehicle)
            figures = stiffened(figures, more)
            if max(more) > MOST_STIFFER:
                why = (
                    f"a suspension may be {max(more):.0%} stiffer than its springs (high roll centre, heavy axle): masses and "
                    "inertias come in proportion to the stiffness"
                )
        assumed = _assumptions(priors, figures)
        if why:
            return self._nothing(vehicle, data, why, priors, assumed)
        choice = Choice(round(full["order"]), round(full["near_order"]), full["points_per_term"])
        try:
            found = fit(chosen, data, priors, figures, choice, rng)
        except ExpansionError as error:
            why = f"{error}: choose a lower order, or more points a term"
            return self._nothing(vehicle, data, why, priors, assumed)
        except FloatingPointError as error:
            return self._nothing(vehicle, data, f"{error}: give narrower priors", priors, assumed)
        return self._told(prepared, vehicle, data, found, priors, assumed, figures, full["model_error_scale"])

    def _nothing(
        self,
        vehicle: Vehicle,
        data: ModelData,
        reason: str,
        priors: Priors,
        assumed: tuple[Assumption, ...],
        found: Fit | None = None,
    ) -> Estimate:
        return Estimate(
            self.name,
            "ran",
            reason,
            nothing(self.parameters, vehicle, reason, priors),
            assumptions=assumed,
            diagnostics=_diagnostics(data, found, self.model),
            witness=True,
        )

    def _told(
        self,
        prepared: Prepared,
        vehicle: Vehicle,
        data: ModelData,
        found: Fit,
        priors: Priors,
        assumed: tuple[Assumption, ...],
        given: Mapping[str, Quantity],
        error_scale: float,
    ) -> Estimate:
        chosen = self.model
        if found.explained < chosen.least_explained:
            why = (
                f"{chosen.title}: it explains {max(found.explained, 0):.0%} of the outputs only ({chosen.least_explained:.0%} are "
                "needed): check channels, signs and units, or the drive holds what the model does not"
            )
            return self._nothing(vehicle, data, why, priors, assumed, found)
        if found.found.error > UNTOLD_ERROR:
            why = (
                f"{chosen.title}: neither an expansion nor draws by the model itself hold its posterior (log likelihood off by "
                f"{found.found.error:.1f}): give narrower priors"
            )
            return self._nothing(vehicle, data, why, priors, assumed, found)
        values = dict(zip(priors.names, (float(v) for v in found.found.posterior.map_value), strict=True))
        moved = further = 0.0
        if self.whole_body:
            spring = sum(given[f"spring_rate_{axle}_npm"].value for axle in ("front", "rear")) / 2
            moved = travel(data)
            further = travel_error(moved, values["sprung_mass_kg"], spring)
        covariance = spread(found, chosen, priors, error_scale, further)
        stds = dict(zip(priors.names, (float(v) for v in np.sqrt(np.diag(covariance))), strict=True))
        figures: dict[str, Figure]
        if self.whole_body:
            figures, hubs = whole_vehicle(values, stds, vehicle, priors)
            assumed = (*assumed, hubs)
        else:
            figures = own_figures(chosen, values, stds)
        known = {} if self.whole_body else {item.name: item for item in priors.items}
        edges = set(found.found.at_edge)
        whole_edge = self.whole_body and bool(edges)
        return Estimate(
            estimator=self.name,
            status="ran",
            reason=f"{chosen.title}: {data.blocks.count} blocks in {len(data.groups)} intervals. {chosen.note}",
            parameters={
                name: answer(name, figure, vehicle, self.name, known.get(name), whole_edge or name in edges)
                for name, figure in figures.items()
            },
            tracks=tracks(found, chosen, data, prepared.time_s, covariance),
            traces=traces(found, chosen, data, prepared.time_s),
            scatters=densities(found, chosen, priors),
            assumptions=assumed,
            diagnostics={**_diagnostics(data, found, chosen), "travel_m": moved},
            used_fraction=data.blocks.count * data.blocks.rows / max(len(prepared.time_s), 1),
            witness=True,
        )


def _assumptions(priors: Priors, figures: Mapping[str, Quantity]) -> tuple[Assumption, ...]:
    given = tuple(Assumption(key, f"{q.value:.4g} ± {q.std:.2g}", q.source) for key, q in figures.items())
    before = tuple(
        Assumption(f"prior of {i.name}", f"{i.distribution.mean:.4g} ± {i.distribution.std:.2g}", i.source)
        for i in priors.items
    )
    return given + before


def _diagnostics(data: ModelData, found: Fit | None, chosen: Model) -> dict[str, float]:
    figures = {"input_rms": data.input_rms, "lively_share": data.rough, "blocks": float(data.blocks.count)}
    if found is None:
        return figures
    posterior = found.found.posterior
    for j, spec in enumerate(chosen.parameters):
        figures[f"{spec.name}_map"] = float(posterior.map_value[j])
        figures[f"{spec.name}_mean"] = float(posterior.mean[j])
        figures[f"{spec.name}_std"] = float(posterior.std[j])
        figures[f"{spec.name}_growth"] = float(found.growth[j])
    return {
        **figures,
        "explained_share": found.explained,
        "log_evidence": posterior.log_evidence,
        "effective_draws": posterior.effective,
        "surrogate_error": found.found.error,
        "domains_laid": float(found.found.refits),
        "model_runs": float(found.runs),
    }
