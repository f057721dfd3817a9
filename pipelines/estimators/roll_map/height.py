"""Answers that need the vehicle's masses: height, stiffness, inertia; their priors, statuses and reasons in words."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from pipelines.estimators.roll_map.answers import from_draws
from pipelines.estimators.roll_map.posterior import Posterior, moments, quantiles
from pipelines.estimators.roll_map.priors import VehicleDraws
from pipelines.results import FloatArray, Identification, ParameterEstimate, Prior


def plain(value: float, std: float) -> str:
    """ "95 950 ± 1 900": the spread to two digits, the value to one more place, thousands parted."""
    if std <= 0 or not math.isfinite(std):
        return f"{value:,.6g}".replace(",", " ")
    place = 1 - math.floor(math.log10(std))
    parts = (f"{round(x, p):,.{max(p, 0)}f}" for x, p in ((value, place + 1), (std, place)))
    return " ± ".join(parts).replace(",", " ")


FEW = 400.0
"""Effective draws up to which peaks of a density are not told."""

MIRRORED = 0.3
"""By what share the product of two arms may be off I/m: mass and inertia are known to some ten per cent, peaks by a bin."""


def two_peaks(values: FloatArray, weight: FloatArray) -> tuple[float, float] | None:
    """The two peaks of a density that has two clearly parted ones (the valley below 70 % of the lower), else None."""
    low, high = quantiles(values, weight, (0.002, 0.998))
    if high <= low:
        return None
    counts, edges = np.histogram(values, bins=48, range=(float(low), float(high)), weights=weight)
    smooth = np.convolve(counts, np.array([1, 3, 5, 6, 5, 3, 1]) / 24, mode="same")
    tops = [i for i in range(1, 47) if smooth[i] >= smooth[i - 1] and smooth[i] > smooth[i + 1]]
    tops = sorted(tops, key=lambda i: -smooth[i])[:2]
    if len(tops) < 2 or smooth[tops[1]] < 0.15 * smooth[tops[0]]:
        return None
    first, last = sorted(tops)
    if last - first < 5 or smooth[first : last + 1].min() > 0.7 * smooth[tops[1]]:
        return None
    return float(0.5 * (edges[first] + edges[first + 1])), float(0.5 * (edges[last] + edges[last + 1]))


def mirrored(peaks: tuple[float, float], posterior: Posterior) -> bool:
    """Whether two heights are each other's mirror image: their arms' product is I/m."""
    height, arm, weight = posterior.values["cg_height_m"], posterior.values["roll_arm_m"], posterior.weight
    (middle, spread), mean = moments(height, weight), float(weight @ arm)
    slope = float(weight @ ((height - middle) * (arm - mean))) / max(spread**2, 1e-12)
    product = moments(posterior.values["mirror"] * arm**2, weight)[0]
    first, second = (mean + slope * (peak - middle) for peak in peaks)
    return abs(first * second / product - 1) < MIRRORED


def _height_reasons(
    posterior: Posterior, stiffness: Prior | None, roll_axis_known: bool, tyres_known: bool
) -> dict[Identification, str]:
    told = "roll motion gives K/(m h)"
    axis = (
        ""
        if roll_axis_known
        else "; the roll axis height is assumed (give roll_center_height_front_m and …_rear_m)"
    )
    if stiffness is None:
        missing = (
            f"{told}, and the height follows only where the roll stiffness is known: give roll_stiffness_nmprad, or spring "
            f"rates, track widths and anti-roll bars"
        )
    else:
        missing = f"{told}; the height follows from the roll stiffness of the {stiffness.source} ({plain(stiffness.value, stiffness.std)} N·m/rad)"
    if stiffness is not None and not tyres_known:
        axis += "; the tyres' part of the roll is assumed (give tire_vertical_rate_npm)"
    mirror, _ = moments(posterior.values["mirror"], posterior.weight)
    flat = ""
    if 0.75 < mirror < 1.33:
        flat = (
            "; the inertia term cannot help: h is near sqrt(I/m), where c = I/(m h) + h does not change with h and its "
            "mirror image fits as well"
        )
    peaks = two_peaks(posterior.values["cg_height_m"], posterior.weight)
    # few draws in a tail make peaks as well
    if peaks is not None and posterior.effective > FEW:
        flat += f"; two heights fit, {peaks[0]:.2f} m and {peaks[1]:.2f} m"
        flat += " (mirror solutions)" if mirrored(peaks, posterior) else ""
    text = missing + axis + flat
    prefix: dict[Identification, str] = {
        "identified": "",
        "weak": "narrowed a little only: ",
        "not_identifiable": "the log does not tell it: ",
    }
    return {status: words + text for status, words in prefix.items()}


RATES = ("roll_stiffness_nmprad", "roll_damping_nmsprad")
"""Of the suspension: the log tells them over m h."""


def prior_of(values: FloatArray, possible: np.ndarray, source: str) -> Prior:
    """The prior of the loaded vehicle that the draws make up."""
    chosen = values[possible]
    return Prior(float(chosen.mean()), float(chosen.std()), source)


def loaded_priors(
    draws: VehicleDraws, height_source: str | None, inertia_source: str, vehicle_load: bool
) -> dict[str, Prior]:
    """Priors of the loaded vehicle by parameter name; the CG heights only where something was known of them."""
    load = "with the stated load" if vehicle_load else "with an unknown load"
    ok = draws.possible
    found = {
        "mass_kg": prior_of(draws.mass, ok, f"vehicle file, {load}"),
        "sprung_mass_kg": prior_of(draws.sprung, ok, f"vehicle file and unsprung masses, {load}"),
        "roll_inertia_kgm2": prior_of(draws.inertia, ok, f"{inertia_source}, {load}"),
    }
    if height_source is not None:
        found["cg_height_m"] = prior_of(draws.height, ok, f"{height_source}, {load}")
        found["sprung_cg_height_m"] = prior_of(
            draws.sprung_height, ok, f"{height_source}, less unsprung masses, {load}"
        )
        found["roll_arm_m"] = prior_of(draws.arm, ok, f"{height_source}, less the roll axis height, {load}")
    return found


def _same(text: str) -> dict[Identification, str]:
    return {"identified": text, "weak": text, "not_identifiable": text}


def _rate_reasons(symbol: str, prior: Prior | None) -> dict[Identification, str]:
    """Words for the suspension's roll stiffness K or damping D."""
    whose = "of the suspension, without the tyres" + (
        ", friction and the dampers' knees at this drive's speeds allowed for" if symbol == "D" else ""
    )
    text = f"follows from {symbol}/(m h) of the log with the height and the sprung mass ({whose})"
    if prior is None:
        bad = f"{text}: these are hardly known"
        return {"identified": text, "weak": f"{text}: known no better than these", "not_identifiable": bad}
    file = f"the {prior.source} knows it better than the height allows the log to tell it"
    return {"identified": text, "weak": text, "not_identifiable": file}


def vehicle_answers(
    posterior: Posterior,
    priors: Mapping[str, Prior],
    roll_axis_known: bool,
    tyres_known: bool,
    quick: tuple[bool, bool],
    reference: Mapping[str, float],
) -> dict[str, ParameterEstimate]:
    """Everything that needs the vehicle's masses. quick: whether the motion told damping and inertia."""
    stiffness = priors.get("roll_stiffness_nmprad")
    height = _height_reasons(posterior, stiffness, roll_axis_known, tyres_known)
    mass = (
        "roll motion does not tell the mass: this is the vehicle file's, with the load (axle loads, suspension forces or a "
        "longitudinal balance would tell it)"
    )
    inertia = "of the whole vehicle about its CG: roll motion tells I/(m h) + h, where it is quick enough; the rest follows from the masses and heights"
    reasons: dict[str, dict[Identification, str]] = {
        "cg_height_m": height,
        "sprung_cg_height_m": height,
        "roll_arm_m": height,
        "roll_stiffness_nmprad": _rate_reasons("K", stiffness),
        "roll_damping_nmsprad": _rate_reasons("D", priors.get("roll_damping_nmsprad")),
        "roll_inertia_kgm2": _same(inertia),
        "mass_kg": _same(mass),
        "sprung_mass_kg": _same(mass),
    }
    untold = {"mass_kg", "sprung_mass_kg"}
    slow = "the quick motion that there is leaves it open: more of quick steering (sine with dwell, 0.5-1 Hz and above) would tell it"
    for name, told in (("roll_damping_nmsprad", all(quick)), ("roll_inertia_kgm2", quick[1])):
        if not told:
            untold.add(name)
            reasons[name] = _same(slow)
    # two heights that fit as well as each other are no answer, however narrow their spread against the prior's
    parted = two_peaks(posterior.values["cg_height_m"], posterior.weight) is not None
    best: Identification = "weak" if parted else "identified"
    found: dict[str, ParameterEstimate] = {}
    for name, words in reasons.items():
        ceiling: Identification = "not_identifiable" if name in untold else best
        if name in RATES and found["cg_height_m"].status == "not_identifiable" and ceiling == "identified":
            # it is the height from before the log times what the log told
            ceiling = "weak"
        found[name] = from_draws(
            name,
            posterior.values[name],
            posterior.weight,
            priors.get(name),
            words,
            reference.get(name),
            ceiling,
        )
    return found


def surprise(posterior: Posterior, priors: Mapping[str, Prior]) -> str | None:
    """A sentence where the posterior sits more than 2.5 prior spreads from a prior."""
    for name in ("cg_height_m", "roll_stiffness_nmprad", "mass_kg", "roll_inertia_kgm2"):
        prior = priors.get(name)
        if prior is None or prior.std <= 0:
            continue
        value, _ = moments(posterior.values[name], posterior.weight)
        away = (value - prior.value) / prior.std
        if math.isfinite(away) and abs(away) > 2.5:
            return f"the log and what was known of {name} disagree ({value:,.5g} against {plain(prior.value, prior.std)})"
    return None
