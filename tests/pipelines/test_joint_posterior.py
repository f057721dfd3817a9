"""The joint posterior: known answers on linear relations, each relation once, contradictions, chaining."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from parsers.drive import ImportRecord
from pipelines.joint.answers import Told, learned_of
from pipelines.joint.conflict import check
from pipelines.joint.counted import counted
from pipelines.joint.inference import infer
from pipelines.joint.information import Spread, prior_spreads, shares, slopes
from pipelines.joint.next_measurement import CANDIDATES, next_measurements
from pipelines.joint.posterior import find_mode, log_density, values_at
from pipelines.joint.profile import departure
from pipelines.joint.vehicle.stated import stated_relations
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.limits import what_limits
from pipelines.results import NextMeasurement, Share
from tests.pipelines.joint_parts import linear, of_output, told_height, vehicle

RECORD = ImportRecord("CSV table", (), "0", "complete", 1, {}, (), "clock", None, 10.0, ())

KNOWN = before_the_log(vehicle())
MASS = ("empty_mass", "load")


def _rng() -> np.random.Generator:
    return np.random.default_rng(3)


def test_linear_relations_give_the_posterior_of_the_normal_equations() -> None:
    relations = [
        linear({"empty_mass": 1.0, "load": 1.0}, 2150.0, 10.0),
        linear({"load": 0.5, "wheelbase": 300.0}, 970.0, 4.0),
    ]
    joint = find_mode(relations, KNOWN)
    rows = np.zeros((2, len(KNOWN.names)))
    for i, weights in enumerate(({"empty_mass": 1.0, "load": 1.0}, {"load": 0.5, "wheelbase": 300.0})):
        for name, weight in weights.items():
            rows[i, KNOWN.index(name)] = weight
    prior = np.diag(KNOWN.std**2)
    noise = np.diag([100.0, 16.0])
    gain = prior @ rows.T @ np.linalg.inv(rows @ prior @ rows.T + noise)
    mean = KNOWN.mean + gain @ (np.array([2150.0, 970.0]) - rows @ KNOWN.mean)
    covariance = prior - gain @ rows @ prior
    assert joint.converged
    assert joint.u == pytest.approx((mean - KNOWN.mean) / KNOWN.std, abs=1e-5)
    assert joint.covariance == pytest.approx(covariance / np.outer(KNOWN.std, KNOWN.std), abs=1e-6)


def test_the_density_is_that_of_prior_and_relations() -> None:
    joint = find_mode([linear({"load": 1.0}, 300.0, 20.0)], KNOWN)
    u = _rng().standard_normal((5, len(joint.u)))
    load = values_at(KNOWN, u)["load"]
    expected = -0.5 * (u**2).sum(axis=1) - 0.5 * ((load - 300.0) / 20.0) ** 2
    assert log_density(joint)(u) == pytest.approx(expected, rel=1e-9)
    assert log_density(joint)(np.full((1, len(joint.u)), 50.0))[0] == -np.inf


def test_the_same_relation_of_two_estimators_counts_once() -> None:
    first = linear({"load": 1.0}, 300.0, 20.0, "sharp")
    second = linear({"load": 1.0}, 310.0, 30.0, "blunt")
    kept, dropped = counted([second, first], KNOWN)
    assert [e.source for e in kept] == ["sharp"]
    assert len(dropped) == 1
    assert "counted once" in dropped[0][1]
    one, both = (infer(e, vehicle(), _rng()) for e in ([first], [first, second]))
    assert one is not None
    assert both is not None
    assert one.parameters["mass_kg"].std == pytest.approx(both.parameters["mass_kg"].std, rel=1e-9)


def test_a_relation_with_broken_figures_is_left_out_and_said() -> None:
    broken = linear({"load": 1.0}, float("nan"), 20.0)
    kept, dropped = counted([broken], KNOWN)
    assert kept == ()
    assert "cannot be used" in dropped[0][1]
    assert infer([broken], vehicle(), _rng()) is None


def test_bits_of_a_known_case() -> None:
    # a sum known to a third of its prior spread teaches log2 3 bits less what rounding the prior by draws costs
    spread = float(np.hypot(KNOWN.std[KNOWN.index("load")], KNOWN.std[KNOWN.index("empty_mass")]))
    mean = float(KNOWN.mean[KNOWN.index("load")] + KNOWN.mean[KNOWN.index("empty_mass")])
    found = infer(
        [linear({"empty_mass": 1.0, "load": 1.0}, mean, spread / np.sqrt(8))], told_height(vehicle()), _rng()
    )
    assert found is not None
    learned = found.record.learned["mass_kg"]
    assert learned.bits == pytest.approx(np.log2(3), abs=0.05)
    assert learned.shares[0].bits == pytest.approx(np.log2(3), abs=0.02)
    assert found.parameters["mass_kg"].status == "weak"
    assert found.record.learned["drag_area_m2"].bits < 0.05
    drag = found.parameters["drag_area_m2"]
    assert drag.status == "not_identifiable"
    # for other drives to be joined with, what this one leaves; of a parameter that is told, just that
    assert found.kept.told["mass_kg"] == (found.parameters["mass_kg"].value, found.parameters["mass_kg"].std)
    assert drag.std is not None
    assert 0.7 * drag.std < found.kept.told["drag_area_m2"][1] < 1.3 * drag.std


def test_densities_integrate_to_one() -> None:
    found = infer([linear({"empty_mass": 1.0, "load": 1.0}, 2100.0, 15.0)], vehicle(), _rng())
    assert found is not None
    learned = found.record.learned["mass_kg"]
    assert np.trapezoid(learned.density, learned.grid) == pytest.approx(1.0, abs=0.01)
    assert np.trapezoid(learned.prior_density, learned.grid) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("heavy", [2077.0, 2250.0])
def test_a_contradiction_is_named_and_the_interval_holds_both(heavy: float) -> None:
    """Beyond doubt (28 standard deviations) nothing is identified, whatever the interval holds."""
    low = of_output(lambda o: o["mass_kg"], 2050.0, 5.0, kind="vertical", carrier="springs")
    high = of_output(lambda o: o["mass_kg"], heavy, 5.0, kind="longitudinal", carrier="torques")
    found = infer([low, high], vehicle(), _rng())
    assert found is not None
    mass = found.parameters["mass_kg"]
    assert mass.low is not None
    assert mass.high is not None
    assert mass.low < 2050 < heavy < mass.high
    surely = heavy > 2200
    assert mass.status == ("weak" if surely else "identified")
    assert ("beyond doubt" if surely else "disagree") in mass.reason
    assert bool(mass.refused) is surely
    assert mass.reason.startswith(mass.refused)
    told = what_limits(RECORD, (), found.parameters, vehicle(), found.record)
    assert any("is it this vehicle's file" in text for text in told) is surely
    assert all(r.probability < 0.003 and r.widened > 1 for r in found.record.relations)
    agreeing = infer(
        [low, of_output(lambda o: o["mass_kg"], 2056.0, 5.0, kind="longitudinal", carrier="torques")],
        vehicle(), _rng(),
    )  # fmt: skip
    assert agreeing is not None
    assert all(r.probability > 0.1 for r in agreeing.record.relations)
    assert "disagree" not in agreeing.parameters["mass_kg"].reason


def test_false_alarms_of_the_check_are_as_rare_as_it_says() -> None:
    rng, alarms, probabilities = _rng(), 0, []
    for _ in range(600):
        truth = rng.standard_normal(len(KNOWN.names)) * KNOWN.std + KNOWN.mean
        load, empty = truth[KNOWN.index("load")], truth[KNOWN.index("empty_mass")]
        relations = [
            linear({"load": 1.0}, load + 20 * rng.standard_normal(), 20.0, "one"),
            linear({"empty_mass": 1.0, "load": 1.0}, load + empty + 10 * rng.standard_normal(), 10.0, "two"),
        ]
        checks = check(find_mode(relations, KNOWN))
        alarms += sum(c.in_conflict for c in checks)
        probabilities += [c.record.probability for c in checks]
    assert alarms <= 18
    # probabilities of right relations are spread evenly
    assert np.mean(probabilities) == pytest.approx(0.5, abs=0.05)


def test_a_search_that_ended_a_hair_early_makes_no_contradiction() -> None:
    """A relation a thousand times sharper than the rest: what the search left undone, a millionth of a nat, was a chi² of 60 and more."""
    relations = [linear({"load": 1.0}, 300.0, 0.15, "sharp"), linear({"load": 1.0}, 320.0, 20.0, "other")]
    joint = find_mode(relations, KNOWN)
    exact = check(joint)
    early = np.zeros(len(joint.u))
    early[KNOWN.index("load")] = 8e-6
    moved = replace(
        joint,
        u=joint.u + early,
        parts=tuple(replace(p, residual=p.residual - p.slope @ early) for p in joint.parts),
    )
    for one, other in zip(exact, check(moved), strict=True):
        assert not one.in_conflict
        assert other.record.chi2 == pytest.approx(one.record.chi2, rel=1e-3, abs=1e-6)
        assert other.shift == pytest.approx(one.shift, rel=1e-3, abs=1e-6)


def test_mass_from_one_relation_sharpens_the_height_of_another() -> None:
    moment = of_output(lambda o: o["mass_kg"] * o["cg_height_m"], 2150 * 0.68, 15.0, kind="pitch")
    mass = of_output(lambda o: o["mass_kg"], 2150.0, 10.0, kind="longitudinal", carrier="torques")
    alone, chained = infer([moment], vehicle(), _rng()), infer([moment, mass], vehicle(), _rng())
    assert alone is not None
    assert chained is not None
    before, after = alone.parameters["cg_height_m"].std, chained.parameters["cg_height_m"].std
    assert before is not None
    assert after is not None
    assert after < 0.5 * before
    # as far as the two errors go: (m h) to 1 %, m to 0.5 %
    assert after == pytest.approx(0.68 * np.hypot(15 / (2150 * 0.68), 10 / 2150), rel=0.1)
    value = chained.parameters["cg_height_m"].value
    assert value == pytest.approx(0.68, abs=2 * after)


def test_a_measurement_leaves_what_was_foretold() -> None:
    base = [of_output(lambda o: o["mass_kg"] * o["cg_height_m"], 2150 * 0.68, 15.0)]
    joint = find_mode(base, KNOWN)
    _, gradients = slopes(joint)
    told = next_measurements(joint, gradients, dict.fromkeys(gradients, 1.0))["cg_height_m"]
    weigh = next(c for c in CANDIDATES if "tilt table" in c.action)
    named = {n.action: n.std_after for n in told}
    assert weigh.action in named
    after = find_mode([*base, of_output(lambda o: o["cg_height_m"], 0.68, 0.0068, carrier="table")], KNOWN)
    _, steeper = slopes(after)
    g = steeper["cg_height_m"]
    assert named[weigh.action] == pytest.approx(float(np.sqrt(g @ after.covariance @ g)), rel=0.05)


def test_two_sensors_are_named_where_four_tell_little_more(monkeypatch: pytest.MonkeyPatch) -> None:
    joint = find_mode([of_output(lambda o: o["mass_kg"] * o["cg_height_m"], 2150 * 0.68, 15.0)], KNOWN)
    _, gradients = slopes(joint)
    table = next(c for c in CANDIDATES if "tilt table" in c.action)
    two = replace(table, way="signal", action="two")
    for std, first in ((0.0095, "two"), (0.005, "four")):
        four = replace(two, action="four", std=(std,), effort=1.15)
        monkeypatch.setattr("pipelines.joint.next_measurement.CANDIDATES", (four, two))
        told = next_measurements(joint, gradients, dict.fromkeys(gradients, 1.0))["cg_height_m"]
        assert told[0].action == first


def test_the_rear_axles_springs_go_down_by_what_the_load_puts_on_them() -> None:
    rear = next(c for c in CANDIDATES if "on the rear axle" in c.action)
    p = {name: np.array([value]) for name, value in KNOWN.at(np.zeros(len(KNOWN.names))).items()}
    load = {"load": np.array([200.0]), "load_x": 0.5 * p["wheelbase"]}
    none, middle = (rear.seen(p | more)[1] for more in ({"load": np.array([0.0])}, load))
    assert none == pytest.approx(0.0, abs=1e-12)
    assert middle == pytest.approx(100.0 * 9.80665 / (2 * p["spring_rear"]))


def test_shares_name_the_relation_that_taught() -> None:
    relations = [
        of_output(lambda o: o["mass_kg"], 2150.0, 10.0, kind="longitudinal", title="torque"),
        of_output(lambda o: o["cg_to_front_axle_m"], 1.35, 0.005, kind="pitch", title="pitch"),
    ]
    joint = find_mode(relations, KNOWN)
    _, gradients = slopes(joint)
    found = shares(joint, gradients, dict.fromkeys(gradients, 1.0))
    first: Share = found["mass_kg"][0]
    assert (first.relation, found["cg_to_front_axle_m"][0].relation) == ("torque", "pitch")
    assert first.std_alone == pytest.approx(10.0, rel=0.05)


def test_a_straight_ridge_is_normal_and_so_is_a_curved_one_along_its_parameter() -> None:
    straight = find_mode([linear({"empty_mass": 1.0, "load": 1.0}, 2150.0, 10.0)], KNOWN)
    assert departure(straight, slopes(straight)[1], ("mass_kg",)) < 1e-3
    # a bounded one is not: the height's square is what is seen
    curved = find_mode([of_output(lambda o: (o["cg_height_m"] - 0.72) ** 2, 0.0, 0.0008)], KNOWN)
    assert departure(curved, slopes(curved)[1], ("cg_height_m",)) > 0.5


def test_a_stated_roll_stiffness_binds_what_makes_it_up() -> None:
    whole = vehicle(roll_stiffness_nmprad=(124e3, 2e3))
    assert stated_relations(whole) == ()
    some = {k: q for k, q in whole.quantities.items() if not k.startswith(("spring", "anti"))}
    only = vehicle().__class__(body="SUV", quantities=some)
    stated = stated_relations(only)
    assert len(stated) == 1
    known = before_the_log(only)
    bound, free = (prior_spreads(known, s, _rng())["roll_stiffness_nmprad"] for s in (stated, ()))
    # what the springs' curve makes of an unknown load comes on top of what is stated of the empty vehicle
    assert bound.mean == pytest.approx(124e3, rel=0.03)
    assert 2e3 < bound.std < 5e3
    assert free.std > 3 * bound.std


def test_what_taught_nothing_brought_nothing_and_help_is_more_than_was_known() -> None:
    """Widened for doubts, a spread may end above what was known before: no relation brought that, and less is not better."""
    prior = Spread(100.0, 4.0, np.random.default_rng(0).normal(100.0, 4.0, 4000))
    following = (NextMeasurement("half as good", 6.0), NextMeasurement("twice as good", 2.0))
    brought = (Share("a relation", 0.5, 7.0, 6.5),)
    for std, bits_, kept, steps in (
        (5.0, 0.0, (), ("twice as good",)),
        (3.0, 0.415, brought, ("twice as good",)),
    ):
        answer = Told(100.0, std, 100 - 2 * std, 100 + 2 * std, None)
        record = learned_of("mass_kg", answer, prior, brought, following)
        assert record.bits == pytest.approx(bits_, abs=1e-3)
        assert record.shares == kept
        assert tuple(step.action for step in record.next) == steps
