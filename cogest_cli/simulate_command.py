"""`cogest simulate`: a manoeuvre with known truth, as a log."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from parsers.errors import SettingsError

if TYPE_CHECKING:
    from pipelines.simulation.logs.drive import Choice, SimulatedLog
    from pipelines.simulation.manoeuvres.base import Options
    from pipelines.simulation.plant.vehicle import PlantVehicle
    from pipelines.simulation.records import Air

HIGHEST_HZ, LOWEST_HZ = 1000.0, 1.0
Side = Literal["left", "right", "both"]


Manoeuvre = Annotated[
    str | None, typer.Argument(metavar="MANOEUVRE", help="Its name; see --list.", show_default=False)
]
Out = Annotated[
    Path | None,
    typer.Option(
        help="The log: .csv or .parquet for one table, a name without suffix for a folder with one a rate.",
        show_default=False,
    ),
]
VehicleName = Annotated[
    str, typer.Option(help="A preset's name, a vehicle file (TOML), or random: one that the seed makes up.")
]
Loads = Annotated[
    list[str] | None,
    typer.Option(
        help="MASS@x=…,y=…,z=… (behind the front axle, left, above ground) or PLACE:MASS, PLACE being roof, rear, "
        "side or seats; may be repeated.",
        show_default=False,
    ),
]
CrossWeight = Annotated[
    float,
    typer.Option(
        help="Mass in kg that unlike spring seats move from front left to front right and from rear right to rear left."
    ),
]
Sensors = Annotated[str, typer.Option(help="A sensor set; see --list.")]
Rate = Annotated[
    float | None,
    typer.Option(help="All signals at this rate in Hz; default: each at its own.", show_default=False),
]
Speed = Annotated[float | None, typer.Option(help="Test speed in km/h.", show_default=False)]
Duration = Annotated[float | None, typer.Option(help="Length in s.", show_default=False)]
Friction = Annotated[
    float | None, typer.Option(help="Peak friction coefficient of the road.", show_default=False)
]
Severity = Annotated[
    float, typer.Option(help="Factor on what makes the manoeuvre hard (steering, braking, roughness).")
]
Direction = Annotated[Side, typer.Option(help="left, right or both, where it has sides.")]
Surface = Annotated[str | None, typer.Option(help="Roughness class of ISO 8608, A to H.", show_default=False)]
Wind = Annotated[float, typer.Option(help="Steady wind in m/s.")]
WindToward = Annotated[
    float,
    typer.Option(
        help="Where the wind blows to, in degrees left of the heading at the start; 0 is from behind."
    ),
]
AirDensity = Annotated[
    float, typer.Option(help="Of the air, kg/m³: 1.1 on a hot day or at 900 m, 1.3 in frost.")
]
SensorErrors = Annotated[float, typer.Option(help="Factor on noise, offsets, scale errors and misalignment.")]
Dropouts = Annotated[float, typer.Option(help="Lost messages of each sensor unit a second.")]
Outliers = Annotated[float, typer.Option(help="Share of wild samples.")]
VehicleErrors = Annotated[float, typer.Option(help="Factor on how far the vehicle file lies from the truth.")]
TellLoad = Annotated[bool, typer.Option("--tell-load", help="Write the load into the vehicle file.")]
Seed = Annotated[int, typer.Option(help="The same seed gives the same files.", min=0)]
Listing = Annotated[
    bool, typer.Option("--list", help="List manoeuvres, vehicles, loads and sensors, and stop.")
]


def simulate(
    manoeuvre: Manoeuvre = None,
    out: Out = None,
    vehicle: VehicleName = "suv",
    load: Loads = None,
    cross_weight: CrossWeight = 0.0,
    sensors: Sensors = "deflection",
    rate: Rate = None,
    speed: Speed = None,
    duration: Duration = None,
    friction: Friction = None,
    severity: Severity = 1.0,
    direction: Direction = "both",
    surface: Surface = None,
    wind: Wind = 0.0,
    wind_toward: WindToward = 180.0,
    air_density: AirDensity = 1.2,
    sensor_errors: SensorErrors = 1.0,
    dropouts: Dropouts = 0.0,
    outliers: Outliers = 0.0,
    vehicle_errors: VehicleErrors = 1.0,
    tell_load: TellLoad = False,
    seed: Seed = 0,
    listing: Listing = False,
) -> None:
    """Write a simulated drive as a log, with its truth and a vehicle file beside it."""
    if listing:
        show_names()
        return
    if manoeuvre is None or out is None:
        missing = "MANOEUVRE" if manoeuvre is None else "--out FILE"
        raise typer.BadParameter(f"{missing} is missing; `cogest simulate --list` names what there is")
    _check_ranges(
        rate, {"--sensor-errors": sensor_errors, "--vehicle-errors": vehicle_errors}, dropouts, outliers
    )
    from pipelines.simulation.logs.drive import Choice
    from pipelines.simulation.logs.loads import parse_load
    from pipelines.simulation.logs.write import check_file

    check_file(out)
    made, said = _vehicle(vehicle, seed)
    found = _warped(made, cross_weight)
    choice = Choice(
        manoeuvre=manoeuvre,
        vehicle=found,
        loads=tuple(part for text in load or () for part in parse_load(text, found)),
        options=_options(speed, severity, duration, friction, direction, surface),
        air=_air(wind, wind_toward, air_density),
        sensors=sensors,
        rate_hz=rate,
        error_scale=sensor_errors,
        dropouts_per_s=dropouts,
        outlier_share=outliers,
        sheet_errors=vehicle_errors,
        tell_load=tell_load,
        seed=seed,
    )
    _write(choice, out, said)


def _options(
    speed: float | None,
    severity: float,
    duration: float | None,
    friction: float | None,
    direction: Side,
    surface: str | None,
) -> Options:
    """The manoeuvre's options; the speed is in km/h. Raises SettingsError for what none can have."""
    from pipelines.simulation.manoeuvres.base import SPEEDS_MPS, Options

    try:
        return Options(
            speed_mps=None if speed is None else speed / 3.6,
            severity=severity,
            duration_s=duration,
            friction=friction,
            direction=direction,
            surface=surface,
        )
    except ValueError as error:
        if speed is not None and str(error).startswith("speed_mps"):
            low, high = (3.6 * bound for bound in SPEEDS_MPS)
            text = f"--speed is {speed:g} km/h: expected {low:g} to {high:g}"
            raise SettingsError(text, wrong_usage=True) from error
        raise SettingsError(str(error), wrong_usage=True) from error


def _air(wind: float, toward: float, density: float) -> Air:
    """What the drive goes through. Raises SettingsError for what no air is."""
    from pipelines.simulation.records import Air

    if not 0 <= wind <= 30:
        raise SettingsError(f"--wind is {wind:g} m/s: expected 0 to 30", wrong_usage=True)
    if not -360 <= toward <= 360:
        raise SettingsError(f"--wind-toward is {toward:g} degrees: expected -360 to 360", wrong_usage=True)
    if not 0.5 <= density <= 2:
        raise SettingsError(f"--air-density is {density:g} kg/m³: expected 0.5 to 2", wrong_usage=True)
    angle = math.radians(toward)
    return Air(density, wind * math.cos(angle), wind * math.sin(angle))


def _check_ranges(rate: float | None, factors: dict[str, float], dropouts: float, outliers: float) -> None:
    """Raise SettingsError for a number that means nothing."""
    if rate is not None and not LOWEST_HZ <= rate <= HIGHEST_HZ:
        raise SettingsError(
            f"--rate is {rate:g} Hz: expected {LOWEST_HZ:g} to {HIGHEST_HZ:g}", wrong_usage=True
        )
    for name, factor in factors.items():
        if not 0 <= factor <= 100:
            raise SettingsError(f"{name} is {factor:g}: expected 0 to 100", wrong_usage=True)
    if not 0 <= dropouts <= 10:
        raise SettingsError(f"--dropouts is {dropouts:g} a second: expected 0 to 10", wrong_usage=True)
    if not 0 <= outliers <= 0.5:
        raise SettingsError(f"--outliers is {outliers:g}: expected a share of 0 to 0.5", wrong_usage=True)


def _vehicle(text: str, seed: int) -> tuple[PlantVehicle, Sequence[str]]:
    """A preset, what a vehicle file describes, or the seed's random vehicle; and what is to be said of it."""
    path = Path(text)
    if path.suffix.lower() == ".toml":
        from cogest_cli.simulated_vehicle import vehicle_of_file

        return vehicle_of_file(path)
    from pipelines.simulation.logs.drive import preset

    return preset(text, seed), ()


def _warped(vehicle: PlantVehicle, cross_weight_kg: float) -> PlantVehicle:
    """The vehicle with its springs warped. Raises SettingsError where that lifts a wheel."""
    if cross_weight_kg == 0:
        return vehicle
    try:
        return replace(vehicle, cross_weight_kg=cross_weight_kg)
    except ValueError as error:
        raise SettingsError(str(error), hint="give less than a corner carries", wrong_usage=True) from error


def _write(choice: Choice, out: Path, said: Sequence[str]) -> None:
    """Drive it, and write the log. said: notes on the vehicle."""
    from cogest_cli.output import show_line
    from cogest_cli.version import version
    from pipelines.simulation.logs.drive import simulate_log, truth_record
    from pipelines.simulation.logs.write import write_log, write_truth, write_vehicle

    simulated = simulate_log(choice)
    files = write_log(simulated.log, out)
    truth = out.with_name(f"{out.stem}.truth.json")
    write_truth(truth_record(simulated, version()), truth)
    sheet = write_vehicle(simulated.sheet, out)
    show_line(f"{simulated.scenario.title}: {_summary(simulated)}")
    if simulated.rolled_over:
        show_line(f"note: the vehicle rolled over after {simulated.run.time_s[-1]:.1f} s; the log ends there")
    for note in said:
        show_line(f"note: {note}")
    for path in (*files, truth, sheet):
        show_line(path)
    beside = [] if sheet.name == "vehicle.toml" else ["--vehicle", str(sheet)]
    show_line(f"next: {shlex.join(['cogest', 'analyze', str(out), *beside])}")


def _summary(simulated: SimulatedLog) -> str:
    from pipelines.simulation.logs.drive import extremes

    peaks, known = extremes(simulated.run), simulated.run.truth
    return (
        f"{simulated.run.time_s[-1]:.0f} s, up to {3.6 * peaks['speed_mps']:.0f} km/h and "
        f"{peaks['lateral_acceleration_g']:.2f} g across; {known['mass_kg']:.0f} kg, CG {known['cg_height_m']:.3f} m high"
    )


def show_names() -> None:
    """Print what can be simulated, one line each."""
    from cogest_cli.output import show_line
    from pipelines.simulation.logs.drive import RANDOM
    from pipelines.simulation.logs.loads import PLACES
    from pipelines.simulation.manoeuvres.registry import MANOEUVRES, title_of
    from pipelines.simulation.plant.vehicle import PRESETS
    from pipelines.simulation.sensors.sets import SENSOR_SETS

    lists = {
        "manoeuvres": {name: title_of(name) for name in MANOEUVRES},
        "vehicles": {
            name: f"{v.body}, {v.mass_kg:.0f} kg empty, wheelbase {v.wheelbase_m:g} m"
            for name, v in PRESETS.items()
        }
        | {RANDOM: "a sedan, hatchback, wagon, SUV, minivan, van or pickup that the seed makes up"},
        "loads": {f"{name}:KG": about for name, (about, _) in PLACES.items()},
        "sensors": {name: title for name, (title, _) in SENSOR_SETS.items()},
    }
    for title, rows in lists.items():
        show_line(f"{title}:")
        for name, about in rows.items():
            show_line(f"  {name:<24} {about}")
