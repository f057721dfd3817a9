"""The general engine from a settings file: any model of the registry by name, priors by parameter, every slip named.

A new model is one file and one registry line: a test here adds one.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import pipelines.models.registry
from parsers.drive import Drive, ImportRecord, Signal
from parsers.errors import SettingsError
from pipelines.analyze import run_estimator
from pipelines.bayes.priors import Beta, Normal, Uniform
from pipelines.estimators.base import FullSettings, configured
from pipelines.estimators.gpc_bayesian_map.chosen import priors_of
from pipelines.estimators.gpc_bayesian_map.estimator import GpcBayesianMap
from pipelines.models.registry import MODELS, model
from pipelines.parameters import PARAMETERS
from pipelines.settings import read_settings, settings_text
from pipelines.vehicles.vehicle import Quantity, Vehicle

KNOWN = (GpcBayesianMap(),)
TABLE = "[gpc_bayesian_map]\n"
STIFFNESS = "[gpc_bayesian_map.priors.roll_stiffness_nmprad]\n"

LAG = """
import numpy as np

from pipelines.bayes.priors import Known, Uniform
from pipelines.models.record import Given, Model, ModelParameter


def predict(values, inputs, step_s, given):
    return values[:, 0, None, None] * given["wheelbase_m"] * inputs[None, :, :1]


def priors(vehicle):
    return {"drag_area_m2": Known("drag_area_m2", Uniform(0.1, 5.0), True, "any car")}


MODEL = Model(
    "gain", "Output in proportion to input", "textbook", (ModelParameter("drag_area_m2", "Gain", "m²", 0.01, 10.0),),
    ("accel_x",), ("accel_y",), (Given("wheelbase_m", "a factor"),), predict, priors, (0.2, 4.0), 8.0, 0.5,
)
"""


def read(tmp_path: Path, text: str) -> FullSettings:
    path = tmp_path / "settings.toml"
    path.write_text(text, encoding="utf-8")
    settings = read_settings(path, KNOWN)["gpc_bayesian_map"]
    assert isinstance(settings, FullSettings)
    return settings


def drive_of(**columns: np.ndarray) -> Drive:
    time = (np.arange(len(next(iter(columns.values())))) * 1e7).astype(np.int64)
    signals = {name: Signal(name, time, values, "made") for name, values in columns.items()}
    record = ImportRecord("made", (), "", "complete", 0, {}, (), "made", None, float(time[-1] / 1e9), ())
    return Drive(signals, record)


def noise(rows: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    time = np.arange(rows) / 100
    return sum(
        np.sin(2 * np.pi * f * time + p)
        for f, p in zip(rng.uniform(0.3, 3, 12), rng.uniform(0, 6, 12), strict=True)
    )


def test_words_and_priors_are_read(tmp_path: Path) -> None:
    settings = read(
        tmp_path,
        TABLE
        + 'model = "roll"\nintervals = 4\n'
        + STIFFNESS
        + 'distribution = "normal"\nvalue = 60e3\nstd = 3000\n',
    )
    assert settings["intervals"] == 4.0
    assert settings.texts == {"model": "roll"}
    chosen = configured(KNOWN[0], settings)
    assert [need.any_of for need in chosen.signal_needs] == [("accel_y",), ("roll",)]
    assert "roll_stiffness_nmprad" in chosen.parameters
    (item, *_) = priors_of(model("roll"), Vehicle(), settings.priors).items
    assert item.distribution == Normal(60e3, 3000.0, 2_000.0, 5_000_000.0)
    assert item.source == "settings file"


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ('distribution = "uniform"\nlow = 2e4\nhigh = 9e4', Uniform(2e4, 9e4)),
        ('distribution = "beta"\nlow = 2e4\nhigh = 9e4\na = 2\nb = 3', Beta(2e4, 9e4, 2.0, 3.0)),
    ],
)
def test_every_form_of_a_prior(tmp_path: Path, entry: str, expected: object) -> None:
    settings = read(tmp_path, TABLE + 'model = "roll"\n' + STIFFNESS + entry)
    assert priors_of(model("roll"), Vehicle(), settings.priors).items[0].distribution == expected


def test_the_printed_file_reads_back(tmp_path: Path) -> None:
    text = settings_text(KNOWN)
    assert 'model = "base_excitation_3dof"' in text
    assert all(name in text for name in MODELS)
    settings = read(tmp_path, text)
    plain = read_settings(None, KNOWN)["gpc_bayesian_map"]
    assert isinstance(plain, FullSettings)
    assert (dict(settings), settings.texts, settings.priors) == (dict(plain), plain.texts, plain.priors)


ROLL = TABLE + 'model = "roll"\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TABLE + 'model = "rol"', r"there is no model 'rol'; did you mean 'roll'"),
        (TABLE + "model = 3", "found 3, expected a word in quotes; known are base_excitation_3dof"),
        (TABLE + "modle = 3", "unknown setting; did you mean 'model'"),
        (TABLE + "priors = 3", "no table of priors"),
        (TABLE + "[gpc_bayesian_map.priors]\nsprung_mass_kg = 3", "a prior is a table"),
        (ROLL + "[gpc_bayesian_map.priors.roll_stifness_nmprad]", "no such parameter; did you mean 'roll_stiffness_nmprad'"),
        (ROLL + "[gpc_bayesian_map.priors.sprung_mass_kg]", "model 'roll' has no such parameter"),
        (ROLL + STIFFNESS + "low = 1", "found distribution None; known are uniform"),
        (ROLL + STIFFNESS + 'distribution = "norml"', "found distribution 'norml'; did you mean 'normal'"),
        (ROLL + STIFFNESS + 'distribution = "normal"\nvalue = 3e4', "no number `std`; a normal prior has value, std"),
        (ROLL + STIFFNESS + 'distribution = "normal"\nvalue = 3e4\nstd = 0', "spread above 0"),
        (ROLL + STIFFNESS + 'distribution = "normal"\nvalue = -1\nstd = 1', "found -1; the model can be run from 2000"),
        (ROLL + STIFFNESS + 'distribution = "uniform"\nlow = 9e4\nhigh = 2e4', "nothing between"),
        (ROLL + STIFFNESS + 'distribution = "uniform"\nlow = 0\nhigh = 2e4', "found 0 to 20000; the model can be run"),
        (ROLL + STIFFNESS + 'distribution = "uniform"\nlo = 1\nhigh = 2e4', "unknown key 'lo'; did you mean 'low'"),
        (ROLL + STIFFNESS + 'distribution = "uniform"\nlow = true\nhigh = 2e4', "found True, expected a finite"),
        (ROLL + STIFFNESS + 'distribution = "uniform"\nlow = nan\nhigh = 2e4', "found nan, expected a finite"),
        (TABLE + "order = 1" + "0" * 400, "expected a finite number"),
        (TABLE + "".join(f"[gpc_bayesian_map.priors.p{i}]\n" for i in range(60)), "60 priors, at most"),
        ("#" * 1_000_001, "no settings file"),
    ],
)  # fmt: skip
def test_slips_are_named(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        read(tmp_path, text)


def test_a_new_model_is_one_file_and_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "gain_model.py").write_text(LAG, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(pipelines.models.registry, "MODELS", {**MODELS, "gain": "gain_model:MODEL"})
    settings = read(tmp_path, TABLE + 'model = "gain"\nmodel_error_scale = 0\n')
    x = noise(6000, 1)
    y = 0.7 * 2.5 * x + 0.05 * np.random.default_rng(2).standard_normal(6000)
    vehicle = Vehicle(quantities={"wheelbase_m": Quantity(2.5, 0.0, "made")}, reference={"drag_area_m2": 0.7})
    found = run_estimator(KNOWN[0], drive_of(accel_x=x, accel_y=y), vehicle, settings, 0)
    answer = found.parameters["drag_area_m2"]
    assert answer.status == "identified"
    assert answer.low is not None
    assert answer.high is not None
    assert answer.value is not None
    assert answer.low <= 0.7 <= answer.high
    assert answer.value == pytest.approx(0.7, rel=0.01)
    lacking = run_estimator(KNOWN[0], drive_of(accel_x=x), vehicle, settings, 0)
    assert lacking.status == "skipped"
    assert "accel_y" in lacking.reason
    sys.modules.pop("gain_model", None)


@pytest.mark.parametrize("name", list(MODELS))
def test_every_model_keeps_the_contract(name: str) -> None:
    """Its record is whole, and its function is one on arrays of the shapes that it says."""
    record = model(name)
    assert record.name == name
    vehicle = Vehicle(
        quantities={
            "mass_kg": Quantity(1600, 20, ""), "wheelbase_m": Quantity(2.7, 0.01, ""), "track_front_m": Quantity(1.55, 0.01, ""),
            "spring_rate_front_npm": Quantity(30e3, 600, ""), "spring_rate_rear_npm": Quantity(31e3, 600, ""),
        }
    )  # fmt: skip
    for who in (vehicle, Vehicle()):
        priors = priors_of(record, who, {})
        assert priors.names == tuple(p.name for p in record.parameters)
        low, high = priors.box()
        assert np.all(np.isfinite(low) & np.isfinite(high) & (low < high))
        for spec, item in zip(record.parameters, priors.items, strict=True):
            assert spec.low <= item.distribution.reach[0] < item.distribution.reach[1] <= spec.high
    given = {key: q.value for key, q in record.figures(vehicle).items()}
    assert set(given) == {g.key for g in record.given}
    points = priors_of(record, vehicle, {}).values(np.vstack((low, high, 0.5 * (low + high))))
    inputs = np.column_stack([noise(500, k) for k in range(len(record.inputs))])
    before = inputs.copy()
    out = record.predict(points, inputs, 0.01, given)
    assert out.shape == (3, 500, len(record.outputs))
    assert np.isfinite(out).all()
    assert np.array_equal(inputs, before)
    np.testing.assert_allclose(record.predict(points[1:2], inputs, 0.01, given)[0], out[1], atol=1e-9)
    assert any(p.name in PARAMETERS for p in record.parameters) or name == "quarter_car"
