"""A load that came or went in mid-drive, as it is told."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from parsers.drive import Decision

APART_S = 30.0
"""From which on both instants are told that a change lies between."""


@dataclass(frozen=True)
class LoadStep:
    """A load that came or went. after_s, before_s: between which instants, from the drive's start. change_kg: + what came; std_kg of it.

    rear, left: share of it on the rear axle and on the left wheels (None where that is not measured). source: signals.
    others: of a drive with several the smaller ones, in the order of time.
    """

    after_s: float
    before_s: float
    change_kg: float
    std_kg: float
    rear: float | None
    left: float | None
    source: str
    others: tuple[LoadStep, ...] = ()

    @property
    def in_order(self) -> tuple[LoadStep, ...]:
        """This one and the others as they came."""
        return tuple(sorted((replace(self, others=()), *self.others), key=lambda step: step.after_s))

    @property
    def most_kg(self) -> float:
        """By how much the heaviest load of the drive is beyond the lightest."""
        loads = np.cumsum([0.0, *(step.change_kg for step in self.in_order)])
        return float(loads.max() - loads.min())

    @property
    def found(self) -> str:
        """The sentence for the reader."""
        return "the load changed " + " and ".join(step._when for step in self.in_order)

    @property
    def _when(self) -> str:
        rounded = 10 * round(self.change_kg / 10)
        when = f"at about {0.5 * (self.after_s + self.before_s):.0f} s"
        if self.before_s - self.after_s > APART_S:
            when = f"between {self.after_s:.0f} and {self.before_s:.0f} s"
        return f"{when} (by about {rounded:+d} kg{self._where})"

    @property
    def _where(self) -> str:
        if self.rear is None:
            return ""
        if self.rear > 0.6:
            return ", more at the rear"
        return ", more at the front" if self.rear < 0.4 else ", at both axles"

    @property
    def _evidence(self) -> str:
        how = "from leg to leg, at a stop" if self.rear is None else "at rest,"
        where = "" if self.rear is None else f", {100 * self.rear:.0f} % of it at the rear"
        return (
            f"{self.change_kg:+.0f} ± {self.std_kg:.0f} kg by {self.source} {how} between {self.after_s:.0f} and "
            f"{self.before_s:.0f} s{where}"
        )

    @property
    def decision(self) -> Decision:
        """As it stands in the import record: nothing was done about it."""
        evidence = "; ".join(step._evidence for step in self.in_order)
        action = "split the drive there; mass, place and heights are weak, with half of what the load changes in their spreads"
        return Decision("", "load", self.found, action, evidence, applied=False)
