"""What the fleet's tables say, as sentences: the same in HTML and PDF."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from pipelines.results import FloatArray
from reports.blocks import Tone
from reports.fleet.failures import KINDS
from reports.fleet.records import NEAR_G, NEAR_PROBABILITY, OUTLYING, FleetView
from reports.fleet.view import title_of
from reports.text import NARROW, clean, count, number, sentence, with_unit

NAMED = 3
"""Of a kind of finding so many are named; the tables hold them all."""


@dataclass(frozen=True)
class Finding:
    """One finding. badge: how many or what, in a tone. show: the filter of the drives' table that shows it, or ""."""

    badge: str
    text: str
    tone: Tone = "plain"
    show: str = ""


def share_text(share: float) -> str:
    """A small share of 1 in percent, without digits that say nothing: 1 %, 0.5 %."""
    return with_unit(f"{100 * share:.2g}", "%")


def expected_text(number_of: float) -> str:
    """How many are to be expected: 0.05, 1.8, 24."""
    return f"{number_of:.2g}" if number_of < 10 else number(number_of, 0)


def _drives(view: FleetView) -> list[Finding]:
    done, failed = view.done, view.failed
    if not view.drives:
        return [Finding("none", "No drive was found in this fleet.", "quiet")]
    out = []
    if failed:
        kinds = Counter(KINDS.get(d.status, d.status) for d in failed)
        each = ", ".join(
            f"{n} {kind}" for kind, n in sorted(kinds.items(), key=lambda pair: (-pair[1], pair[0]))
        )
        text = (
            f"{count(len(failed), 'drive')} of {number(len(view.drives), 0)} could not be analysed: {each}."
        )
        out.append(Finding(f"{len(failed)} failed", text, "bad", "failed"))
    else:
        every = "All drives were" if len(done) > 1 else "The drive was"
        out.append(Finding("complete", f"{every} analysed.", "good"))
    return out


def _half(low: FloatArray, high: FloatArray) -> FloatArray:
    return 0.5 * (high - low)


def _sharper(view: FleetView) -> str:
    """How much narrower the CG height's interval is with all drives of a vehicle joined, in the middle; or nothing."""
    own, joined = view.own.get("cg_height_m"), view.joined.get("cg_height_m")
    if own is None or joined is None:
        return ""
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = _half(joined.low, joined.high) / _half(own.low, own.high)
    ratio = ratio[np.isfinite(ratio)]
    if ratio.size < 2:
        return ""
    return (
        f" With all drives of a vehicle joined, its 95{NARROW}% interval is {number(float(np.median(ratio)), 2)} times as wide"
        f" as from the drive alone (median of {count(int(ratio.size), 'drive')})."
    )


def _heights(view: FleetView) -> list[Finding]:
    if not view.done:
        return []
    answers = view.joined.get("cg_height_m") or view.own.get("cg_height_m")
    own = view.own.get("cg_height_m")
    codes = [0] * len(view.drives)
    for source in (own, answers):
        if source is not None:
            codes = [new or old for old, new in zip(codes, source.status, strict=True)]
    done = [code for code, d in zip(codes, view.drives, strict=True) if d.status == "done"]
    told = Counter(done)
    if told[1] + told[2] == 0:
        return [
            Finding(
                "not known",
                "No drive could tell the CG height of its vehicle; its own report says what was missing.",
                "quiet",
            )
        ]
    rest = told[0] + told[3]
    text = (
        f"The CG height is identified in {count(told[1], 'drive')}, weakly told in {number(told[2], 0)}, "
        f"and could not be told in {number(rest, 0)}.{_sharper(view)}"
    )
    return [Finding(f"{told[1] + told[2]} of {len(done)} told", text, "good" if told[1] else "warn")]


def _loads(view: FleetView) -> list[Finding]:
    compared = sum(v.compared for v in view.vehicles)
    if not compared:
        if not any(v.changes for v in view.vehicles):
            return []
        return [
            Finding(
                "loads not told",
                "Whether loads changed cannot be told: the drives' measurements do not see the load.",
                "quiet",
            )
        ]
    found = sum(v.changed for v in view.vehicles)
    rate = view.facts.false_alarm_rate
    chance = ""
    if rate is not None:
        chance = (
            f" False-alarm rate {share_text(rate)}: about {expected_text(rate * compared)} of"
            f" {number(compared, 0)} comparisons would say so by chance."
        )
    where = sum(v.changed > 0 for v in view.vehicles)
    if not found:
        text = f"No change of load was detected in {count(compared, 'comparison')} of a drive with the one before.{chance}"
        return [Finding("no load change", text, "quiet")]
    text = (
        f"The load changed before {count(found, 'drive')} of {count(where, 'vehicle')}"
        f" ({count(compared, 'drive')} compared with the one before).{chance}"
    )
    return [Finding(count(found, "load change"), text, "warn", "changed")]


def _drifts(view: FleetView) -> list[Finding]:
    looked = sum(v.looked for v in view.vehicles)
    found = [(v, row) for v in view.vehicles for row in v.trends if row["detected"]]
    if not looked and not found:
        why = Counter(clean(row["text"] or "", 200) for v in view.vehicles for row in v.trends).most_common(1)
        reason = f": {why[0][0].removeprefix('cannot be told: ')}" if why and why[0][0] else ""
        return (
            [
                Finding(
                    "drifts not told",
                    sentence(f"Whether springs or dampers drift cannot be told{reason}"),
                    "quiet",
                )
            ]
            if why
            else []
        )
    if not found:
        text = f"No spring or damper is seen to drift ({count(looked, 'trend')} looked at)."
        return [Finding("no drift", text, "quiet")]
    found.sort(key=lambda pair: (_chance(pair[1]["probability"]), pair[0].label))
    named = "; ".join(
        f"{v.label}, {title_of(row)}: {clean(row['text'] or '', 200)}" for v, row in found[:NAMED]
    )
    return [Finding(count(len(found), "drift"), sentence(named + _more(len(found)), 900), "warn")]


def _more(found: int) -> str:
    """What follows those that are named."""
    return f"; and {found - NAMED} more" if found > NAMED else ""


def _chance(value: object) -> float:
    return value if isinstance(value, float) else 1.0


def _outliers(view: FleetView) -> list[Finding]:
    if not view.outliers:
        return []
    found = [v for v in view.vehicles if v.outlying and v.outlier is not None]
    if not found:
        text = f"No vehicle stands out: {count(len(view.outliers), 'vehicle')} compared with others of the kind, or with the data sheet."
        return [Finding("no outlier", text, "quiet")]
    found.sort(key=lambda v: (_chance(v.outlier["probability"] if v.outlier else None), v.label))
    named = "; ".join(
        f"{v.label}: {clean((v.outlier or {}).get('text') or '', 260).rstrip('.')}" for v in found[:NAMED]
    )
    text = sentence(named + _more(len(found)), 1200)
    text += f" {share_text(OUTLYING)} of vehicles would be called outliers by chance."
    return [Finding(count(len(found), "outlier"), text, "warn")]


def _near(view: FleetView) -> list[Finding]:
    known = [
        d for d in view.done if d.margin_g is not None or d.exceedance is not None or d.lifts is not None
    ]
    if not known:
        return []
    near = [d for d in known if d.near]
    what = (
        f"least margin {number(NEAR_G, 2)}{NARROW}g or less, a probability of {share_text(NEAR_PROBABILITY)} or more of having"
        " reached the threshold, or a wheel lift"
    )
    if not near:
        return [
            Finding(
                "none near rollover",
                f"None of {count(len(known), 'drive')} came near rollover ({what}).",
                "good",
            )
        ]
    lifted = sum(bool(d.lifts) for d in near)
    lifts = f"; wheels lifted in {number(lifted, 0)}" if lifted else ""
    text = f"{count(len(near), 'drive')} came near rollover{lifts} ({what})."
    return [Finding(f"{len(near)} near rollover", text, "bad", "near")]


def _gone(view: FleetView) -> list[Finding]:
    gone = sum(d.gone for d in view.drives) or view.facts.gone
    if not gone:
        return []
    text = f"The logs of {count(gone, 'drive')} are no longer in the folder; what is known of them is kept."
    return [Finding(f"{gone} without logs", text, "quiet")]


def _left_out(view: FleetView) -> list[Finding]:
    """Files of the folder that are in no drive: one of them may be a log that somebody misses."""
    named = [f"{clean(name, 80)}: {clean(why, 200)}" for name, why in view.facts.left_out_named[:NAMED]]
    if not named:
        return []
    total = len(view.facts.left_out_named)
    text = f"{count(total, 'file')} below the folder {'is' if total == 1 else 'are'} in no drive: {'; '.join(named)}{_more(total)}"
    return [Finding(f"{total} left out", sentence(text, 1200), "quiet")]


def _misfits(view: FleetView) -> list[Finding]:
    """Drives that contradict the others of their vehicle, such as one in a wrong folder."""
    found = [d for d in view.drives if d.apart == "misfit"]
    if not found:
        return []
    named = "; ".join(f"{d.name} ({view.vehicles[d.vehicle].label})" for d in found[:NAMED])
    one = len(found) == 1
    text = (
        f"{count(len(found), 'drive')} {'does' if one else 'do'} not go with the others of {'its' if one else 'their'} vehicle and"
        f" {'is' if one else 'are'} left out of its joined answers: {named}{_more(len(found))}. Is it another vehicle's, in a wrong"
        " folder? Else the vehicle file is another one, parts were changed, or a sensor was moved."
    )
    return [Finding(f"{len(found)} {'does' if one else 'do'} not fit", text, "warn")]


def _copies(view: FleetView) -> list[Finding]:
    """Drives that are in the folder twice."""
    found = [d for d in view.drives if d.apart == "copy"]
    if not found:
        return []
    named = "; ".join(d.name for d in found[:NAMED])
    text = (
        f"{count(len(found), 'drive')} {'is a copy' if len(found) == 1 else 'are copies'} of another drive of the same vehicle, or a"
        f" part of one; each recording counts once: {named}{_more(len(found))}."
    )
    return [Finding(count(len(found), "copy", "copies"), text, "quiet")]


def _not_joined(view: FleetView) -> list[Finding]:
    """Vehicles with several drives of which no answer is a joint one."""
    joined = {k for a in view.joined.values() for k, code in enumerate(a.status) if code}
    told = {k for a in view.own.values() for k, code in enumerate(a.status) if code in (1, 2)}
    apart = [
        v for v in view.vehicles if len(told.intersection(v.drives)) > 1 and not joined.intersection(v.drives)
    ]
    if not apart:
        return []
    text = f"The drives of {count(len(apart), 'vehicle')} are not joined ({', '.join(v.label for v in apart[:NAMED])}{_more(len(apart))}): each speaks alone."
    why = [
        note
        for v in apart
        for d in v.drives
        for note in view.drives[d].notes
        if "could not be joined" in note
    ]
    if why:
        text += f" {sentence(why[0], 300)}"
    return [Finding(f"{len(apart)} not joined", text, "warn")]


def _untold(view: FleetView) -> list[Finding]:
    answers = [*view.own.values(), *view.joined.values()]
    told = {k for a in answers for k, code in enumerate(a.status) if code in (1, 2)}
    mute = [
        v.label
        for v in view.vehicles
        if not told.intersection(v.drives)
        and not any(row["status"] in ("identified", "weak") for row in v.shared)
    ]
    if not mute or not view.done:
        return []
    named = ", ".join(mute[:6]) + (f" and {len(mute) - 6} more" if len(mute) > 6 else "")
    text = (
        f"Nothing could be told of {count(len(mute), 'vehicle')}: {named}. Their drives say what was missing."
    )
    return [Finding(f"{len(mute)} silent", text, "quiet")]


def findings_of(view: FleetView) -> tuple[Finding, ...]:
    """All findings, what asks for attention first where there is any."""
    found = [
        *_drives(view), *_near(view), *_loads(view), *_drifts(view), *_outliers(view), *_misfits(view), *_heights(view), *_not_joined(view), *_untold(view), *_gone(view), *_copies(view), *_left_out(view)
    ]  # fmt: skip
    found += [Finding("note", sentence(note), "quiet") for note in view.facts.notes]
    return tuple(found)
