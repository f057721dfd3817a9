"""A small fleet: four vehicles, each with a folder, a vehicle file and drives of its own; one log is cut off, and of one nothing can be read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipelines.simulation.logs.drive import Choice, default_mount, preset, simulate_log, truth_record
from pipelines.simulation.logs.loads import parse_load
from pipelines.simulation.logs.vehicle import data_sheet
from pipelines.simulation.logs.write import write_truth
from pipelines.simulation.manoeuvres.base import Options
from pipelines.simulation.plant.vehicle import PlantVehicle
from sample_logs.writers import can, ros, text
from sample_logs.writers.common import SampleDrive, on_one_clock, one_clock_sensors

RATE_HZ = 20.0
KEPT_OF_THE_BROKEN = 0.6
KEPT_OF_THE_UNREADABLE = 0.4


def _blf(drive: SampleDrive, path: Path) -> None:
    can.write_with_python_can(can.frames(drive), path)


def _mcap(drive: SampleDrive, path: Path) -> None:
    ros.write_mcap_ros(drive, path, ros1=False)


def _bag(drive: SampleDrive, path: Path) -> None:
    ros.write_bag1(drive, path)


WRITERS: dict[str, Callable[[SampleDrive, Path], None]] = {
    ".csv": text.write_csv,
    ".parquet": text.write_parquet,
    ".vbo": text.write_vbo,
    ".blf": _blf,
    ".mf4": can.write_mf4_channels,
    ".mcap": _mcap,
    ".bag": _bag,
}


@dataclass(frozen=True)
class FleetDrive:
    """One log. loads: as for `cogest simulate --load`. broken: cut off in the middle, as by a dead battery. unreadable: a copy
    that broke off before what says where its data are."""

    file: str
    manoeuvre: str
    loads: tuple[str, ...]
    duration_s: float | None = None
    broken: bool = False
    unreadable: bool = False


@dataclass(frozen=True)
class FleetVehicle:
    """One folder. beside: files that its logs need, name -> text."""

    folder: str
    preset: str
    drives: tuple[FleetDrive, ...]
    beside: tuple[tuple[str, str], ...] = ()


FLEET: tuple[FleetVehicle, ...] = (
    FleetVehicle(
        "suv",
        "suv",
        (
            FleetDrive("monday.mcap", "public_road", ("seats:75",), 100.0),
            FleetDrive("tuesday.csv", "mixed_minute", ("seats:150", "roof:80")),
            FleetDrive("wednesday.mcap", "launch_and_stop", ("seats:75", "rear:150"), 60.0, broken=True),
        ),
        (("map.toml", ros.MAP),),
    ),
    FleetVehicle(
        "sedan",
        "sedan",
        (
            FleetDrive("track.vbo", "mixed_minute", ("seats:75",)),
            FleetDrive("town.parquet", "urban", ("seats:300", "rear:60"), 100.0),
        ),
        (("map.toml", text.VBO_MAP),),
    ),
    FleetVehicle(
        "van",
        "van",
        (
            FleetDrive("tour_1.blf", "rural", ("seats:75", "side:200"), 120.0),
            FleetDrive("tour_2.mf4", "public_road", ("seats:150", "rear:500"), 100.0),
            FleetDrive("yard.csv", "mixed_minute", ("seats:75", "roof:100")),
        ),
        (("map.toml", can.MAP), ("chassis.dbc", can.DBC)),
    ),
    FleetVehicle(
        "truck",
        "truck",
        (
            FleetDrive("hill.csv", "hills", ("2000@x=3.2,y=0,z=1.6",), 120.0),
            FleetDrive("depot.bag", "launch_and_stop", ("800@x=3.0,y=0.2,z=1.9",), 80.0),
            FleetDrive(
                "harbour.parquet", "launch_and_stop", ("1200@x=3.1,y=0,z=1.7",), 40.0, unreadable=True
            ),
        ),
        (("map.toml", ros.MAP),),
    ),
)


def _drive(vehicle: PlantVehicle, item: FleetDrive, seed: int, folder: Path) -> None:
    simulated = simulate_log(
        Choice(
            item.manoeuvre,
            vehicle,
            loads=tuple(part for spec in item.loads for part in parse_load(spec, vehicle)),
            options=Options(duration_s=item.duration_s),
            sensors=one_clock_sensors(default_mount(vehicle), RATE_HZ),
            seed=seed,
        )
    )
    path = folder / item.file
    WRITERS[path.suffix](on_one_clock(simulated.log), path)
    if item.broken or item.unreadable:
        data = path.read_bytes()
        kept = KEPT_OF_THE_BROKEN if item.broken else KEPT_OF_THE_UNREADABLE
        path.write_bytes(data[: int(len(data) * kept)])
    write_truth(truth_record(simulated, "samples"), folder / f"{path.stem}.truth.json")


def write_fleet(root: Path) -> None:
    """Write the fleet below `root`; what stood there under the same names is replaced."""
    seed = 0
    for number, item in enumerate(FLEET):
        folder = root / item.folder
        folder.mkdir(parents=True, exist_ok=True)
        vehicle = preset(item.preset)
        sheet = data_sheet(vehicle, default_mount(vehicle), np.random.default_rng([7, number]))
        (folder / "vehicle.toml").write_text(sheet, encoding="utf-8")
        for name, content in item.beside:
            (folder / name).write_text(content, encoding="utf-8")
        for drive in item.drives:
            seed += 1
            _drive(vehicle, drive, seed, folder)
