"""The vehicle as its rollover needs it: draws of every quantity, from the verdict, the vehicle file, or what is usual."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from pipelines.joint.vehicle.feet import PATCH_FOLLOWS, ROLLING_SIDE_RATE, USUAL_GIVE
from pipelines.models.roll import DEGREES, GRAVITY
from pipelines.results import Assumption, FloatArray, ParameterEstimate
from pipelines.rollover.draws import COUNT, SEED, from_interval, from_quantity, log_normal
from pipelines.vehicles.vehicle import Quantity, Vehicle

Verdict = Mapping[str, ParameterEstimate]

OFFSET = (0.0, 0.02)
GRADIENT = (5.5, 1.8)
AXIS = (0.08, 0.05)
UNSPRUNG_SHARE = (0.11, 0.025)
WHEEL_RADIUS = (0.33, 0.03)
SPIN = (0.010, 0.004)
SAG = (0.17, 0.04)
JACKING = (1.0, 0.5)
TIRE_SAG = (0.02, 0.006)
STIFFENING = (0.95, 0.12)
GYRATION = (0.15, 0.03)
MODEL_STD = 0.02
IMU_PLACE = 0.4
USUAL_HZ, USUAL_DAMPING = 1.6, 0.3
"""What is usual where neither the log nor the vehicle file tells, mean and standard deviation. OFFSET m: a driver alone.
GRADIENT deg a sensed g: cars 3-9. AXIS m: roll axis above ground. UNSPRUNG_SHARE of the mass. SPIN m: what the wheels' gyroscopic
moment adds to the height, sum of I_w / R over the mass. SAG m: weight over the springs' rate (a ride of 1.2 Hz). JACKING:
share of what ideal roll centres would lift the body; a live axle lifts it not at all, bump stops lift it more. TIRE_SAG m: squash of
the tyres at rest. STIFFENING: roll gradient near the
limit over the one measured: stops stiffen the roll, an axle whose inner wheel is off softens it. GYRATION: roll inertia
over mass and track². MODEL_STD: the whole relation, relative. IMU_PLACE m: along the vehicle, where it is not stated. USUAL_HZ, USUAL_DAMPING: of the roll
motion, where no angle shows it and the verdict is silent."""


@dataclass(frozen=True)
class Body:
    """Draws, all (n,), SI; one draw is one vehicle. `nominal` gives the medians as arrays of one.

    track: across both contact lines at the CG's place between the axles. offset: CG left of its middle. lever: what the CG
    moves to the right a radian of roll. arm: CG above the roll axis (h_r of the dissertation). gradient: rad a sensed g.
    spin: m added to the height in turns. jacking: m of rise a g at the limit. axis: roll axis above ground. tilt: what the CG moves to the
    side, in m, because the tyres give way once one side carries all, beyond what the whole lean says. give: m a g that loads go with their patches to a bend's inside while all wheels share them. inertia: m²,
    of (*) in `limits`, over the mass. stiffening, model: factors. imu_ahead: of the CG;
    imu_above: over the roll axis; imu_left: m. roll_hz, roll_damping: of the roll motion. told: the verdict's CG height.
    """

    height: FloatArray
    track: FloatArray
    offset: FloatArray
    lever: FloatArray
    arm: FloatArray
    gradient: FloatArray
    spin: FloatArray
    jacking: FloatArray
    axis: FloatArray
    tilt: FloatArray
    give: FloatArray
    inertia: FloatArray
    stiffening: FloatArray
    model: FloatArray
    imu_ahead: FloatArray
    imu_above: FloatArray
    imu_left: float
    roll_hz: float
    roll_damping: float
    gradient_known: bool
    told: ParameterEstimate
    assumptions: tuple[Assumption, ...]

    def nominal(self) -> Body:
        """The medians."""
        drawn: dict[str, Any] = {
            f.name: np.array([np.median(values)])
            for f in fields(self)
            if isinstance(values := getattr(self, f.name), np.ndarray)
        }
        return replace(self, **drawn)


class _Sources:
    """Draws by name, each from a stream of its own in a fixed order, and the words on where they came from."""

    def __init__(self, verdict: Verdict, vehicle: Vehicle) -> None:
        self._verdict, self._vehicle = verdict, vehicle
        self.real = vehicle.real
        self._rng = np.random.default_rng(SEED)
        self.assumptions: list[Assumption] = []

    def normal(self) -> FloatArray:
        return self._rng.standard_normal(COUNT)

    def learned(self, name: str, *, positive: bool = True) -> FloatArray | None:
        """From the verdict; None where it gives no figures."""
        entry, z = self._verdict.get(name), self.normal()
        if entry is None or entry.value is None or not entry.std or (positive and entry.value <= 0):
            return None
        return from_interval(entry, z, positive=positive)

    def stated(self, key: str) -> FloatArray | None:
        """From the vehicle file."""
        quantity, z = self._vehicle.get(key), self.normal()
        return None if quantity is None else from_quantity(quantity, z)

    def usual(self, what: str, figure: tuple[float, float], unit: str, why: str) -> FloatArray:
        """What is usual, written down."""
        text = f"{figure[0]:g} ± {figure[1]:g} {unit}".strip()
        self.assumptions.append(Assumption(f"rollover: {what}", text, why))
        return figure[0] + figure[1] * self.normal()


def mean_track(vehicle: Vehicle) -> Quantity | None:
    """The mean of the vehicle file's track widths, as in the static stability factor; None without any."""
    known = [q for key in ("track_front_m", "track_rear_m") if (q := vehicle.get(key)) is not None]
    if not known:
        return None
    return Quantity(sum(q.value for q in known) / len(known), max(q.std for q in known), "vehicle file")


def rear_share(verdict: Verdict, vehicle: Vehicle) -> float:
    """Where the CG lies between the axles: a / L; half where it is not known."""
    place, length = verdict.get("cg_to_front_axle_m"), vehicle.get("wheelbase_m")
    value = place.value if place is not None else None
    stated = vehicle.get("cg_to_front_axle_m")
    value = stated.value if value is None and stated is not None else value
    if value is None or length is None or not 0 < value < length.value:
        return 0.5
    return value / length.value


def _by_axle(sources: _Sources, share: float, keys: tuple[str, str]) -> FloatArray | None:
    """A figure of the two axles at the CG's place between them; one alone stands for both."""
    front, rear = (sources.stated(key) for key in keys)
    if front is None or rear is None:
        return front if rear is None else rear
    return (1 - share) * front + share * rear


def _masses(sources: _Sources, vehicle: Vehicle) -> tuple[FloatArray | None, FloatArray]:
    """Whole mass (None: not known), and the unsprung share of it."""
    mass = sources.learned("mass_kg")
    unsprung = [sources.stated(f"unsprung_mass_{axle}_kg") for axle in ("front", "rear")]
    if mass is not None and unsprung[0] is not None and unsprung[1] is not None:
        return mass, np.clip((unsprung[0] + unsprung[1]) / mass, 0.01, 0.4)
    share = sources.usual("unsprung share of the mass", UNSPRUNG_SHARE, "", "not in the vehicle file")
    return mass, np.clip(share, 0.02, 0.4)


def _spin(sources: _Sources, mass: FloatArray | None) -> FloatArray:
    """Sum of I_w / R over the mass: (sum I_w v / R) yaw_rate is m a_y times this."""
    inertia, radius = sources.stated("wheel_inertia_kgm2"), sources.stated("wheel_radius_m")
    if mass is not None and inertia is not None and radius is not None:
        return np.maximum(4 * inertia / (radius * mass), 0.0)
    usual = sources.usual(
        "height added by the wheels' spin", SPIN, "m", "no wheel inertia in the vehicle file"
    )
    return np.maximum(usual, 0.0)


def _sag(sources: _Sources, mass: FloatArray | None) -> FloatArray:
    """Weight over the rate of the four springs, m."""
    front, rear = (sources.stated(f"spring_rate_{axle}_npm") for axle in ("front", "rear"))
    if mass is not None and front is not None and rear is not None:
        return np.clip(mass * GRAVITY / (2 * (front + rear)), 0.01, 0.5)
    return np.clip(
        sources.usual("weight over spring rate", SAG, "m", "no spring rates or mass known"), 0.02, 0.5
    )


def _tire_sag(sources: _Sources, mass: FloatArray | None) -> FloatArray:
    """Squash of the four tyres under the standing vehicle, m."""
    rate = sources.stated("tire_vertical_rate_npm")
    if mass is not None and rate is not None:
        return np.clip(mass * GRAVITY / (4 * rate), 0.003, 0.08)
    return np.clip(
        sources.usual("squash of the tyres at rest", TIRE_SAG, "m", "no tyre rate or mass known"), 0.005, 0.08
    )


def _sideways(sources: _Sources, mass: FloatArray | None, squash: FloatArray) -> FloatArray:
    """m a g that the tyres' loads go to a bend's inside with their patches, while all wheels share them."""
    rate = sources.stated("tire_lateral_rate_npm")
    if mass is not None and rate is not None:
        share, unsure = PATCH_FOLLOWS
        return np.maximum(share + unsure * sources.normal(), 0.0) * mass * GRAVITY / (4 * rate)
    follows = sources.usual(
        "share of the tyres' way across by which their loads go along",
        USUAL_GIVE[sources.real],
        "",
        "tyres differ; no lateral rate in the vehicle file",
    )
    return np.maximum(follows, 0.0) * squash / ROLLING_SIDE_RATE


def _gyration(
    sources: _Sources, height: FloatArray, track: FloatArray, arm: FloatArray, share: FloatArray,
    radius: FloatArray, mass: FloatArray | None,
) -> FloatArray:  # fmt: skip
    """I of (*) over the mass: I_s + m_s z_s (h_s - h), with the sprung CG z_s above the roll axis and f_y at the whole CG.

    It is less than the whole vehicle's roll inertia, whose wheels do not roll with the body.
    """
    whole = sources.learned("roll_inertia_kgm2")
    if mass is None or whole is None:
        usual = sources.usual("roll inertia over mass and track²", GYRATION, "", "inertia or mass not known")
        return np.maximum(usual, 0.03) * track**2
    above = share * (height - radius) / (1 - share)
    hubs = share * ((track / 2) ** 2 + (height - radius) ** 2)
    own = whole / mass - hubs - (1 - share) * above**2
    return np.asarray(np.maximum(own + (1 - share) * (arm + above) * above, 0.02 * track**2))


def _imu(
    sources: _Sources, verdict: Verdict, vehicle: Vehicle, axis: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """How far the inertial unit sits ahead of the CG, and above the roll axis."""
    z, up = sources.normal(), sources.normal()
    behind, above = (vehicle.sensors.get(k) for k in ("imu_behind_front_axle_m", "imu_above_ground_m"))
    place = sources.learned("cg_to_front_axle_m")
    if behind is None or place is None:
        text = "sensors.imu_behind_front_axle_m or the CG's place is not known"
        sources.assumptions.append(
            Assumption("rollover: accelerometer along the vehicle", f"at the CG ± {IMU_PLACE:g} m", text)
        )
        ahead = IMU_PLACE * z
    else:
        ahead = place - behind.value - behind.std * z
    ground = 0.5 + 0.2 * up if above is None else above.value + above.std * up
    return ahead, ground - axis


def _height_and_track(
    verdict: Verdict, vehicle: Vehicle, sources: _Sources, share: float
) -> tuple[ParameterEstimate, FloatArray, FloatArray] | str:
    """The verdict's CG height with its draws, and those of the track; or why there are none."""
    entry = verdict.get("cg_height_m")
    if entry is None or entry.value is None or not entry.std or entry.value <= 0:
        return "the CG height is not known"
    track = _by_axle(sources, share, ("track_front_m", "track_rear_m"))
    if track is None:
        return "the vehicle file gives no track width"
    return entry, from_interval(entry, sources.normal(), positive=True), np.maximum(track, 0.2)


def _lean(sources: _Sources, fitted: Quantity | None) -> tuple[FloatArray, bool]:
    """Roll gradient in rad a sensed g, and whether it is known: from the verdict, else from this drive's roll angle."""
    gradient = sources.learned("roll_gradient_degpg")
    z = sources.normal()
    known = gradient is not None or fitted is not None
    if gradient is None and fitted is not None:
        text = f"{fitted.value:.1f} ± {fitted.std:.1f} deg/g"
        sources.assumptions.append(Assumption("rollover: roll gradient", text, fitted.source))
        gradient = fitted.value + fitted.std * z
    if gradient is None:
        gradient = sources.usual(
            "roll gradient", GRADIENT, "deg/g", "no roll gradient in the verdict, and no roll angle"
        )
    return np.clip(gradient, 0.3, 15.0) / DEGREES, known


def _middle(verdict: Verdict, name: str, usual: float) -> float:
    """A positive figure of the verdict, or what is usual."""
    entry = verdict.get(name)
    return entry.value if entry is not None and entry.value is not None and entry.value > 0 else usual


def draw_body(verdict: Verdict, vehicle: Vehicle, fitted: Quantity | None = None) -> Body | str:
    """The vehicle's draws; or why there are none: the CG height or the track is not known.

    fitted: roll gradient in deg/g that the drive itself shows, for where the verdict has none.
    """
    sources = _Sources(verdict, vehicle)
    share = rear_share(verdict, vehicle)
    found = _height_and_track(verdict, vehicle, sources, share)
    if isinstance(found, str):
        return found
    told, height, track = found
    offset = sources.learned("cg_lateral_offset_m", positive=False)
    if offset is None:
        offset = sources.usual(
            "CG lateral offset", OFFSET, "m", "not in the verdict; a driver alone gives 0.02 m"
        )
    mass, unsprung = _masses(sources, vehicle)
    radius = sources.stated("wheel_radius_m")
    radius = WHEEL_RADIUS[0] + WHEEL_RADIUS[1] * sources.normal() if radius is None else radius
    axis = _by_axle(sources, share, ("roll_center_height_front_m", "roll_center_height_rear_m"))
    if axis is None:
        axis = sources.usual("roll axis above ground", AXIS, "m", "no roll centres in the vehicle file")
    axis = np.minimum(axis, 0.8 * height)
    gradient, known = _lean(sources, fitted)
    arm = height - axis
    share_lifted = sources.usual(
        "share of ideal jacking", JACKING, "", "suspensions differ; live axles do not jack"
    )
    stiffening = sources.usual(
        "roll gradient near the limit over the measured one", STIFFENING, "", "bump stops, a lifted axle"
    )
    # m_s z_s / m = h - axis - (m_u / m) (h_u - axis): the wheels do not lean with the body
    lever = np.maximum(arm - unsprung * (radius - axis), 0.05)
    ahead, above = _imu(sources, verdict, vehicle, axis)
    left = vehicle.sensors.get("imu_left_m")
    sources.assumptions.append(
        Assumption(
            "rollover: error of the relation itself",
            f"{100 * MODEL_STD:g} %",
            "simulated vehicles of five kinds",
        )
    )
    squash = _tire_sag(sources, mass)
    return Body(
        height=height, track=track, offset=offset, arm=arm,
        lever=lever, tilt=(height - lever) * 2 * squash / track,
        gradient=gradient, spin=_spin(sources, mass), axis=axis,
        jacking=np.clip(share_lifted, 0.0, 2.2) * np.maximum(2 * axis / track, 0.0) * _sag(sources, mass),
        inertia=_gyration(sources, height, track, arm, unsprung, radius, mass),
        stiffening=np.clip(stiffening, 0.4, 1.6), model=log_normal(1.0, MODEL_STD, sources.normal()), give=_sideways(sources, mass, squash),
        imu_ahead=ahead, imu_above=above, imu_left=0.0 if left is None else left.value,
        roll_hz=_middle(verdict, "roll_natural_frequency_hz", USUAL_HZ), roll_damping=_middle(verdict, "roll_damping_ratio", USUAL_DAMPING),
        gradient_known=known,
        told=told, assumptions=tuple(sources.assumptions),
    )  # fmt: skip
