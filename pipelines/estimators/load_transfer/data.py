"""From prepared signals to what load transfer needs: strut forces, vertical accelerations over the struts, level motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.models.load_transfer import Size, corners_from_imu, rotation
from pipelines.models.roll import GRAVITY
from pipelines.prepare.banked import banked_all_round, pressed_on
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import BoolArray, Prepared
from pipelines.prepare.roll_angle import TYPICAL_TRACK
from pipelines.prepare.signals import prepare_signals
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray
from pipelines.vehicles.usual import usual_radius, usual_unsprung, usual_wheel_inertia
from pipelines.vehicles.vehicle import Quantity, Vehicle

FORCES: tuple[str, ...] = tuple(f"suspension_force_{w}" for w in WHEELS)
CORNERS: tuple[str, ...] = tuple(f"accel_z_sprung_{w}" for w in WHEELS)
DEFLECTIONS: tuple[str, ...] = tuple(f"suspension_deflection_{w}" for w in WHEELS)
SPEEDS: tuple[str, ...] = ("speed", "gps_speed_2d", "gps_speed_3d")
BESIDE: tuple[str, ...] = (
    *CORNERS, *DEFLECTIONS, *SPEEDS, "accel_x", "accel_y", "accel_z", "roll_rate", "pitch_rate", "yaw_rate",
    "brake_pressure", *(f"wheel_speed_{w}" for w in WHEELS),
)  # fmt: skip

BRAKING = 0.7
SHORTEST_S = 2.0
BESIDE_STD = (1.5, 0.02)
GRADE_HZ = 0.25
TYRES = 1.15
OFFSET_STD = {"x": 0.17, "y": 0.16}
LEANING = 0.9
ROAD_STD = {"x": 0.010, "y": 0.025}
LEAN = {"x": (0.06, 0.04), "y": (0.09, 0.04)}
"""BESIDE_STD: of the square of the yaw rate (m) and
of the lateral force (s²/m): a sliding vehicle is slowed by its own turn. BRAKING: m/s² of deceleration taken
for braking where no pressure is logged. OFFSET_STD: m/s², what an accelerometer's offset, its mounting and the body's
standing lean make together; LEANING of it where deflections tell the lean. ROAD_STD: rad, mean grade and cross slope of a drive (roads fall to one side by 2 to 2.5 %). LEAN: share by which the body's lean
enlarges the force that it feels, mean and standard deviation over cars. GRADE_HZ: slower than
braking and driving, as hills are. TYRES: lean over that of the springs alone."""


@dataclass(frozen=True)
class Known:
    """What the vehicle file tells. unsprung: front and rear axle, kg. place: of the inertial unit, behind and left, m."""

    wheelbase: Quantity
    track: tuple[Quantity, Quantity]
    unsprung: tuple[Quantity, Quantity]
    place: tuple[float, float]
    wheel_radius: Quantity
    wheel_inertia: Quantity

    @property
    def size(self) -> Size:
        """Wheelbase and the mean of the tracks."""
        return Size(self.wheelbase.value, 0.5 * (self.track[0].value + self.track[1].value))

    @property
    def unsprung_kg(self) -> float:
        """Of the whole vehicle."""
        return self.unsprung[0].value + self.unsprung[1].value


@dataclass(frozen=True)
class StrutData:
    """Usable rows of a drive, (n,) or (n, 4) by wheel, cut into runs; SI, ISO 8855.

    forces: of the struts. corners: vertical specific force over each strut, its mean set to gravity. vertical: that of
    the inertial unit, or the corners' mean. along, across: horizontal specific force as the leaning body feels it, offsets
    taken out as far as speed and yaw rate show them; offset_std: what is left of them, m/s². roll, pitch: of the body
    against its axles, 0 where no deflection is logged. braking: 1 where the brakes are on. starts: 1 where a run begins. moving: all rows are of a moving vehicle.
    """

    time_s: FloatArray
    rate_hz: float
    forces: FloatArray
    corners: FloatArray
    vertical: FloatArray
    along: FloatArray
    across: FloatArray
    offset_std: tuple[float, float]
    roll: FloatArray
    pitch: FloatArray
    speed: FloatArray | None
    yaw_rate: FloatArray
    roll_acceleration: FloatArray
    pitch_acceleration: FloatArray
    braking: FloatArray
    starts: FloatArray
    rows: np.ndarray
    drive_rows: int
    moving: bool
    words: tuple[str, ...]

    @property
    def size(self) -> int:
        """Rows."""
        return len(self.time_s)


def known_of(vehicle: Vehicle) -> Known | None:
    """Lengths and masses from the vehicle file, the usual where it is silent; None without a wheelbase."""
    wheelbase = vehicle.get("wheelbase_m")
    if wheelbase is None:
        return None
    usual = Quantity(*TYPICAL_TRACK, "usual for cars")
    front = vehicle.get("track_front_m") or vehicle.get("track_rear_m") or usual
    rear = vehicle.get("track_rear_m") or front
    mass = vehicle.get("mass_kg")
    heavy = 1800.0 if mass is None else mass.value
    unsprung = tuple(
        vehicle.get(f"unsprung_mass_{name}_kg")
        or Quantity(*usual_unsprung(vehicle, name, heavy), "usual share of the mass")
        for name in ("front", "rear")
    )
    radius = vehicle.get("wheel_radius_m") or Quantity(*usual_radius(vehicle), "usual of its mass")
    behind, left = (vehicle.sensors.get(k) for k in ("imu_behind_front_axle_m", "imu_left_m"))
    place = (0.5 * wheelbase.value if behind is None else behind.value, 0.0 if left is None else left.value)
    return Known(
        wheelbase, (front, rear), (unsprung[0], unsprung[1]), place,
        radius, vehicle.get("wheel_inertia_kgm2") or Quantity(*usual_wheel_inertia(vehicle, radius.value), "usual"),
    )  # fmt: skip


def prepare_struts(drive: Drive, rate_hz: float | None, cutoff_hz: float) -> Prepared:
    """The four strut forces and whatever else is there on one clock, low-passed alike."""
    signals = drive.signals
    wanted = list(FORCES)
    if all(name in signals for name in CORNERS):
        wanted += CORNERS
    elif "accel_z" in signals:
        wanted.append("accel_z")
    wanted += [name for name in ("accel_x", "accel_y") if name in signals]
    return prepare_signals(
        drive, wanted, rate_hz=rate_hz, cutoff_hz=cutoff_hz, optional=[n for n in BESIDE if n not in wanted]
    )


def _column(columns: Mapping[str, FloatArray], name: str, rows: np.ndarray) -> FloatArray | None:
    """A column at these rows, small holes bridged; None where it is not there for most of them."""
    values = columns.get(name)
    if values is None:
        return None
    part = values[rows]
    there = np.isfinite(part)
    if there.mean() < 0.9:
        return None
    if there.all():
        return np.asarray(part)
    at = np.arange(len(part))
    return np.asarray(np.interp(at, at[there], part[there]))


def _all(columns: Mapping[str, FloatArray], names: tuple[str, ...], rows: np.ndarray) -> FloatArray | None:
    found = [_column(columns, name, rows) for name in names]
    if any(c is None for c in found):
        return None
    return np.column_stack([c for c in found if c is not None])


def speed_of(columns: Mapping[str, FloatArray], rows: np.ndarray) -> tuple[FloatArray, str] | None:
    """Speed at these rows and its source; the median wheel where there is no vehicle speed."""
    for name in SPEEDS:
        found = _column(columns, name, rows)
        if found is not None:
            return found, name
    wheels = _all(columns, tuple(f"wheel_speed_{w}" for w in WHEELS), rows)
    return None if wheels is None else (np.asarray(np.median(wheels, axis=1)), "median wheel speed")


def _rate(values: FloatArray, starts: FloatArray, rate_hz: float) -> FloatArray:
    """Time derivative, run by run."""
    out = np.zeros(len(values))
    begin = np.flatnonzero(starts > 0.5)
    for first, past in zip(begin, [*begin[1:], len(values)], strict=True):
        if past - first > 1:
            out[first:past] = np.gradient(values[first:past]) * rate_hz
    return out


def _rows(prepared: Prepared) -> tuple[np.ndarray, FloatArray, bool]:
    """Rows to be used, where runs begin, and whether the vehicle moves at them."""
    good: BoolArray = np.zeros(len(prepared.time_s), dtype=bool)
    for segment in prepared.segments:
        good[segment.start : segment.stop] = True
    still = prepared.standstill
    moving = good & ~still if len(still) == len(good) else good
    shortest = SHORTEST_S * prepared.rate_hz
    # a standstill tells static loads only, and stuck springs: it is for drives that have nothing else
    use = moving if moving.sum() >= 10 * shortest else good
    spans = [(i, j) for i, j in runs(use) if j - i >= shortest]
    if not spans:
        return np.zeros(0, dtype=np.int64), np.zeros(0), False
    rows = np.concatenate([np.arange(i, j) for i, j in spans])
    starts = np.zeros(len(rows))
    starts[np.concatenate(([0], np.cumsum([j - i for i, j in spans])[:-1]))] = 1.0
    return rows, starts, use is moving and bool(still.any() or moving.any())


def _offset(
    force: FloatArray, path: FloatArray | None, beside: FloatArray, axis: str, share: float
) -> tuple[float, float]:
    """What to take from a horizontal force for it to be 0 on a level road, and what is left of that, m/s².

    path: what the wheels' motion says of the force (dv/dt, v times yaw rate). force - path = offset + lean x force + what
    goes with `beside` (n, c; its coefficients near 0 within BESIDE_STD), with the road's mean slope in the offset: the
    sensor's offset is expected to be larger than that. share: of OFFSET_STD, which holds the body's standing lean too.
    """
    sensor, road = share * OFFSET_STD[axis], GRAVITY * ROAD_STD[axis]
    if path is None:
        return 0.0, sensor
    lean, spread = LEAN[axis]
    x = np.column_stack((np.ones(len(force)), force, beside))
    prior = np.array([0.0, lean, *np.zeros(beside.shape[1])])
    std = np.array([10 * sensor, spread, *BESIDE_STD[: beside.shape[1]]])
    # a difference of 0.3 m/s² stays together for a second or so: few rows are independent
    rows = max(len(force) / 30, 1.0)
    curvature = x.T @ x / len(force) * rows / 0.3**2 + np.diag(std**-2.0)
    target = x.T @ (force - path) / len(force) * rows / 0.3**2 + prior / std**2
    inverse = np.linalg.inv(curvature)
    seen, doubt = float((inverse @ target)[0]), float(np.hypot(road, np.sqrt(inverse[0, 0])))
    weight = sensor**2 / (sensor**2 + doubt**2)
    return weight * seen, float(np.sqrt(weight) * doubt)


def _standing(angle: FloatArray, force: FloatArray) -> float:
    """The body's angle without horizontal force: the intercept of a straight line, rad."""
    centred = force - force.mean()
    slope = centred @ angle / max(float(centred @ centred), 1e-3 * len(force))
    return float(angle.mean() - slope * force.mean())


def _banked(path: FloatArray | None, felt: FloatArray | None, *, moving: bool) -> bool:
    """Whether the road leans into bends of one direction throughout: what is felt less of them is then no sensor's offset."""
    return moving and path is not None and felt is not None and banked_all_round(path, felt)


def _normal_gravity(along: FloatArray, path: FloatArray | None, rate_hz: float) -> float:
    """Gravity's part normal to the road in the mean of the drive: g (1 - grade² / 2), from what drives uphill."""
    if path is None:
        return GRAVITY
    lean = LEAN["x"][0] * along
    grade = lowpass(along - path - lean, rate_hz, GRADE_HZ) / GRAVITY
    return GRAVITY * float(1 - 0.5 * np.mean(np.clip(grade, -0.3, 0.3) ** 2))


def _levelled(vertical: FloatArray, along: FloatArray, across: FloatArray, gravity: float) -> FloatArray:
    """A vertical reading that is gravity in the mean of the drive, where no horizontal force leans on it; (n,) or (n, 4).

    A vehicle does not rise, roll or pitch for ever: this takes out offsets, and makes sensors that read 0 at rest read
    9.81. A leaning body feels part of a horizontal force as vertical, by its square; over the struts only the mean has it.
    """
    x = np.column_stack((np.ones(len(along)), across**2, along**2))
    # a lean of 0.1 rad a g, give or take, where the force hardly changes
    ridge = np.diag([0.0, *(np.full(2, 1e4 * len(along) / 3000))])
    heave = vertical if vertical.ndim == 1 else vertical.mean(axis=1)
    level = float(np.linalg.solve(x.T @ x + ridge, x.T @ heave)[0])
    if vertical.ndim == 1:
        return np.asarray(vertical + (gravity - level))
    apart = vertical - heave[:, None]
    return np.asarray((heave + (gravity - level))[:, None] + apart - apart.mean(axis=0))


def _angles(
    columns: Mapping[str, FloatArray], known: Known, rows: np.ndarray
) -> tuple[FloatArray, FloatArray, str | None]:
    """Roll and pitch against the axles from the deflections; zeros, and no words, without."""
    deflections = _all(columns, DEFLECTIONS, rows)
    if deflections is None:
        return np.zeros(len(rows)), np.zeros(len(rows)), None
    fl, fr, rl, rr = deflections.T
    roll = 0.5 * ((fr - fl) / known.track[0].value + (rr - rl) / known.track[1].value)
    pitch = (fl + fr - rl - rr) / (2 * known.wheelbase.value)
    return np.asarray(roll), np.asarray(pitch), "roll and pitch from deflections"


def _turning(
    columns: Mapping[str, FloatArray], rows: np.ndarray, starts: FloatArray, rate_hz: float
) -> tuple[FloatArray | None, FloatArray | None, FloatArray]:
    """Roll and pitch acceleration by the gyros (None without) and the yaw rate."""
    found = [_column(columns, f"{axis}_rate", rows) for axis in ("roll", "pitch", "yaw")]
    roll, pitch = (None if g is None else _rate(g, starts, rate_hz) for g in found[:2])
    yaw = np.zeros(len(rows)) if found[2] is None else found[2]
    return roll, pitch, yaw


def collect(prepared: Prepared, known: Known) -> StrutData | None:
    """The usable rows; None where there are none, or nothing vertical to weigh with."""
    rows, starts, moving = _rows(prepared)
    if not len(rows):
        return None
    c, n, rate_hz = prepared.columns, len(rows), prepared.rate_hz
    forces, strut_accels, vertical = (
        _all(c, FORCES, rows),
        _all(c, CORNERS, rows),
        _column(c, "accel_z", rows),
    )
    if forces is None or (strut_accels is None and vertical is None):
        return None
    zero = np.zeros(n)
    raw = {axis: _column(c, f"accel_{axis}", rows) for axis in "xy"}
    found = speed_of(c, rows)
    gyro_roll, gyro_pitch, yaw = _turning(c, rows, starts, rate_hz)
    yaw_offset = prepared.standstill_offset.get("yaw_rate", (0.0, 0.0))[0]
    yaw = yaw - yaw_offset if "yaw_rate" in c else yaw
    speed = None if found is None else found[0]
    paths = {
        "x": None if speed is None else _rate(speed, starts, rate_hz),
        "y": None if speed is None or "yaw_rate" not in c else speed * yaw,
    }
    banked = _banked(paths["y"], raw["y"], moving=moving)
    roll, pitch, angle_words = _angles(c, known, rows)
    leaning = angle_words is not None
    across = raw["y"] if raw["y"] is not None else zero if paths["y"] is None else paths["y"]
    beside = {"x": np.column_stack((yaw**2, across**2)), "y": np.zeros((n, 0))}
    level: dict[str, FloatArray] = {}
    doubt: dict[str, float] = {}
    for axis, angle in (("x", -pitch), ("y", roll)):
        column = raw[axis]
        instead = paths[axis] if moving and not (banked and axis == "y") else None
        if column is None:
            level[axis], doubt[axis] = (zero if instead is None else instead), GRAVITY * ROAD_STD[axis] * 3
        else:
            column = column - GRAVITY * TYRES * _standing(angle, column)
            offset, doubt[axis] = _offset(column, instead, beside[axis], axis, LEANING if leaning else 1.0)
            level[axis] = column - offset
    normal_gravity = _normal_gravity(level["x"], paths["x"] if raw["x"] is not None else None, rate_hz)
    if banked and paths["y"] is not None and raw["y"] is not None:
        normal_gravity *= pressed_on(paths["y"], raw["y"]) / GRAVITY
    normal = None if vertical is None else _levelled(vertical, level["x"], level["y"], normal_gravity)
    if strut_accels is not None:
        corners = _levelled(strut_accels, level["x"], level["y"], normal_gravity)
        how = "vertical acceleration: an accelerometer over each strut"
        gyro_roll, gyro_pitch = rotation(corners, known.size)
    else:
        assert normal is not None
        gyro_roll, gyro_pitch = (zero if g is None else g for g in (gyro_roll, gyro_pitch))
        corners = corners_from_imu(normal, gyro_roll, gyro_pitch, known.place, known.size)
        how = "vertical acceleration over each strut: from the inertial unit's and its rates"
    pressure = _column(c, "brake_pressure", rows)
    braking = level["x"] < -BRAKING if pressure is None else pressure > 1e5
    return StrutData(
        prepared.time_s[rows], rate_hz, forces, corners, corners.mean(axis=1) if normal is None else normal,
        level["x"], level["y"], (doubt["x"], doubt["y"]), roll, pitch, speed, yaw, gyro_roll, gyro_pitch,
        braking.astype(np.float64), starts, rows, len(prepared.time_s), moving,
        (how, angle_words or "no angles: deflections are not logged", "no speed" if found is None else f"speed: {found[1]}"),
    )  # fmt: skip
