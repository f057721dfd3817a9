"""How to read the report: the few words that a customer may not know."""

from __future__ import annotations

from pipelines.drive_results import DriveResults
from reports.blocks import Block, Fact, Facts
from reports.sections.contract import Plots
from reports.sections.values import has_result
from reports.sections.verdict import ordered
from reports.text import spec_of

TERMS: tuple[tuple[str, str], ...] = (
    ("95 % interval", "the range in which the true value lies with 95 % probability, if what was taken as given is right."),
    ("identified", "the log narrowed the parameter well beyond what was known before."),
    ("weak", "the log narrowed it little, or not far enough to build on: the interval says how far."),
    ("not identifiable", "the log says nothing of use about it; the prior beside it is general knowledge, not a result."),
    ("prior", "what was known before the log: the vehicle file, or the spread among measured vehicles."),
    ("relation", "one piece of physics that the log shows: how far the springs sink, how the body rolls in a turn, what a torque does to the speed."),
    ("bit", "what halves a spread: after two bits an interval is a quarter as wide."),
    ("conflict", "a relation that does not go with all others and with what was known: one of them is wrong, and the intervals hold both."),
    ("published method", "a method as printed by others; it stands beside the verdict as a witness and does not enter it where cogest has an answer."),
    ("CG", "centre of gravity of the whole vehicle as loaded, its height taken above ground."),
    ("static stability factor", "track over twice the CG height; with a rigid body and a flat road, the lateral acceleration in g at which the inner wheels lift."),
    ("rollover threshold", "the same with the body's roll allowed for, which lowers it; quasi-static, no trip and no curb."),
    ("share moved across", "the rollover coefficient: load of the left less that of the right wheels, over their sum; at 1 one side carries nothing."),
    ("axes", "ISO 8855: x forward, y left, z up. In a left turn lateral acceleration, yaw rate and roll are positive."),
)  # fmt: skip


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The chapter: the terms, and what exactly each parameter with a result is."""
    told = [spec_of(each.name) for each in ordered(results.verdict.values()) if has_result(each)]
    exactly: dict[str, Fact] = {}
    for spec in told:
        if spec.meaning:
            # the four wheels' figures mean the same: one line for them
            exactly.setdefault(spec.meaning, Fact(spec.title, f"{spec.meaning}."))
    facts = (*(Fact(term, text) for term, text in TERMS), *exactly.values())
    return (Facts(facts, prose=True),)
