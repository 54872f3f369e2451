"""A rover and its ground written as a MuJoCo model (MJCF): plain text, MuJoCo itself not needed.

Axes as in `rovernav.rover.Chassis`: x forward, y left, z up from the rover's middle, level with its
axles. The base has six joints, x, y, z, heading, pitch (nose up) and roll (left side up), in this
order, so that their values are those of `rovernav.rover.Settled`.
"""

from __future__ import annotations

import math
from typing import Literal, get_args
from xml.etree import ElementTree as Xml

import numpy as np

from ..core import F64, Bool, InputError, SettingError, suggest
from ..rover import Chassis, Mobility, Rover
from ..terrain import Terrain

Wheels = Literal["sphere", "cylinder"]
Steering = Literal["skid", "corners"]

BASE = ("x", "y", "z", "heading", "pitch", "roll")
SIDES = ("left", "right")
STEP = 0.002
"""Time step [s]."""
STIFF = {"solref": "0.005 1", "solimp": "0.95 0.99 0.0005"}
"""Contacts and the differential give way by tenths of a millimetre, not by MuJoCo's millimetres."""
WHEEL_MASS, ROCKER_MASS, BOGIE_MASS = 0.02, 0.02, 0.01
"""Shares of the rover's mass in each wheel, rocker and bogie: assumptions; the rest is the body."""
GEARED, ANSWER = 50.0, 0.01
"""Inertia of a geared motor as its wheel feels it, in that of the wheel's load moving with its rim;
time in which it follows a command [s]. MuJoCo's solver takes a light wheel with a stiff motor for a
light wheel alone, and such rovers hardly turn by skidding."""
BASE_DEPTH = 2.0
"""How far the ground reaches below its lowest post [m]."""


def mjcf(
    terrain: Terrain, rover: Rover, *, wheels: Wheels = "sphere", steering: Steering = "skid"
) -> str:
    """The model as text. Heights of the ground are not in it: `heights` has them.

    Raises:
        SettingError: Unknown wheels or steering, a rover without wheels or mass.
        InputError: Heights are missing: MuJoCo's height fields have no holes.
    """
    for what, got, kind in (("wheels", wheels, Wheels), ("steering", steering, Steering)):
        if got not in get_args(kind):
            raise SettingError(f"unknown {what} {got!r}; {suggest(got, get_args(kind))}")
    chassis, mobility = _parts(rover)
    root = Xml.Element("mujoco", model=rover.name)
    _add(root, "compiler", angle="radian", autolimits="true")
    _add(
        root, "option", timestep=f"{STEP}", gravity=f"0 0 {-mobility.gravity}",
        integrator="implicitfast", cone="elliptic", impratio="10", iterations="200",
        tolerance="1e-12",  # with the default of 1e-8 light rovers never come to rest
    )  # fmt: skip
    _looks(root, terrain)
    world = _add(root, "worldbody")
    _ground(world, terrain)
    base = _add(world, "body", name="base")
    for name in BASE[:3]:
        axis = " ".join(str(int(name == other)) for other in BASE[:3])
        _add(base, "joint", name=name, type="slide", axis=axis)
    for name, axis in zip(BASE[3:], ("0 0 1", "0 -1 0", "1 0 0"), strict=True):
        _add(base, "joint", name=name, type="hinge", axis=axis)
    _body(base, rover, chassis, mobility)
    for side, y in zip(SIDES, (0.5 * rover.track, -0.5 * rover.track), strict=True):
        _side(base, rover, (side, y), (wheels, steering))
    if chassis.suspension != "rigid":
        equality = _add(root, "equality")
        _add(
            equality, "joint", joint1="rocker_right", joint2="rocker_left",
            polycoef="0 -1 0 0 0", **STIFF,
        )  # fmt: skip
    turned = steered_wheels(rover) if steering == "corners" else np.zeros(chassis.wheels, bool)
    _motors(
        root, (rover, mobility), [n for n, t in zip(wheel_names(rover), turned, strict=True) if t]
    )
    return Xml.tostring(root, encoding="unicode")


def heights(terrain: Terrain) -> np.ndarray:
    """Heights of the posts as shares of their span (h, w), float32: MuJoCo's field, row 0 south."""
    low, span = _span(terrain)
    return (terrain.height - low) / np.float32(span)


def wheel_names(rover: Rover) -> list[str]:
    """Names of the wheels, left side first, from front to rear."""
    count = len(_parts(rover)[0].wheel_x)
    return [f"wheel_{side}_{k}" for side in SIDES for k in range(count)]


def wheel_places(rover: Rover) -> tuple[F64, F64]:
    """Places x and y of the wheels, in the order of `wheel_names` (k,) [m]."""
    x = np.array(_parts(rover)[0].wheel_x)
    return np.tile(x, 2), np.repeat([0.5 * rover.track, -0.5 * rover.track], len(x))


def steered_wheels(rover: Rover) -> Bool:
    """Which wheels turn into an arc where corners are steered: all but the middle one of three."""
    count = len(_parts(rover)[0].wheel_x)
    return np.tile(np.arange(count) != (1 if count == 3 else -1), 2)


def middle_mass(rover: Rover) -> tuple[float, float]:
    """Place the centre of mass of the whole rover, in its own axes [m].

    As high as makes the rover tip over sideways at `static_tilt`.
    """
    chassis, _ = _parts(rover)
    high = 0.5 * rover.track / math.tan(chassis.static_tilt)
    return chassis.mass_x, high - rover.wheel_radius


def _add(parent: Xml.Element, tag: str, **said: str) -> Xml.Element:
    return Xml.SubElement(parent, tag, said)


def _parts(rover: Rover) -> tuple[Chassis, Mobility]:
    if rover.mobility is None or rover.chassis is None or rover.track == 0.0:
        raise SettingError(
            f"rover {rover.name} says nothing of its mass and wheels, so no physics can move it; "
            "give its file the sections mobility and chassis"
        )
    return rover.chassis, rover.mobility


def _span(terrain: Terrain) -> tuple[float, float]:
    if terrain.finite < 1.0:
        raise InputError(
            f"{terrain.name}: {1.0 - terrain.finite:.2%} of the heights are missing, and MuJoCo's "
            "height fields have no holes; choose ground without"
        )
    low, high = float(terrain.height.min()), float(terrain.height.max())
    return low, max(high - low, 1e-3)  # MuJoCo refuses a height of 0


def _looks(root: Xml.Element, terrain: Terrain) -> None:
    """Light, colours and the size of pictures."""
    visual = _add(root, "visual")
    _add(visual, "global", offwidth="1600", offheight="1000")
    _add(visual, "headlight", ambient="0.25 0.25 0.25", diffuse="0.25 0.25 0.25")
    _add(visual, "quality", shadowsize="4096")
    _add(visual, "map", znear="0.002", zfar="20")
    extent = max(terrain.frame.extent)
    _add(root, "statistic", extent=f"{extent}", meansize="0.1")
    asset = _add(root, "asset")
    _add(
        asset, "texture", type="skybox", builtin="gradient", rgb1="0.93 0.80 0.68",
        rgb2="0.72 0.56 0.46", width="64", height="64",
    )  # fmt: skip
    h, w = terrain.frame.shape
    _, span = _span(terrain)
    c = terrain.frame.cell
    size = f"{0.5 * (w - 1) * c} {0.5 * (h - 1) * c} {span} {BASE_DEPTH}"
    _add(asset, "hfield", name="ground", nrow=f"{h}", ncol=f"{w}", size=size)


def _ground(world: Xml.Element, terrain: Terrain) -> None:
    """Posts are the middles of cells: the first lies half a cell from the frame's corner."""
    (width, height), (low, span) = terrain.frame.extent, _span(terrain)
    _add(
        world, "geom", name="ground", type="hfield", hfield="ground", rgba="0.67 0.44 0.31 1",
        pos=f"{0.5 * width} {0.5 * height} {low}", contype="1", conaffinity="0", **STIFF,
    )  # fmt: skip
    _add(
        world, "light", directional="true", castshadow="true", diffuse="0.75 0.72 0.68",
        pos=f"0 0 {low + span + 50.0}", dir="0.6 0.35 -0.75",
    )  # fmt: skip


def _body(base: Xml.Element, rover: Rover, chassis: Chassis, mobility: Mobility) -> None:
    """The box that stands on the belly, its mass placed so that the whole's is where it should."""
    sides = len(SIDES)
    shares = [(WHEEL_MASS * sides, x, 0.0) for x in chassis.wheel_x]
    if chassis.suspension != "rigid":
        shares.append((ROCKER_MASS * sides, *chassis.rocker))
    if chassis.suspension == "rocker-bogie":
        shares.append((BOGIE_MASS * sides, *chassis.bogie))
    rest = 1.0 - sum(share for share, _, _ in shares)
    x, z = (
        (whole - sum(part[0] * part[axis] for part in shares)) / rest
        for axis, whole in zip((1, 2), middle_mass(rover), strict=True)
    )
    belly, tall = rover.clearance - rover.wheel_radius, 0.5 * chassis.belly_width
    a, b, c = chassis.belly_length, chassis.belly_width, tall
    mass = rest * mobility.mass
    spin = [mass * (p * p + q * q) / 12.0 for p, q in ((b, c), (a, c), (a, b))]
    _add(
        base, "inertial", pos=f"{x} 0 {z}", mass=f"{mass}",
        diaginertia=" ".join(str(max(s, 1e-6)) for s in spin),
    )  # fmt: skip
    _add(
        base, "geom", name="belly", type="box", rgba="0.93 0.91 0.86 1", **_SOLID,
        pos=f"{chassis.belly_x} 0 {belly + 0.5 * tall}",
        size=f"{0.5 * a} {0.5 * b} {0.5 * tall}", friction="0.3", **STIFF,
    )  # fmt: skip


_SOLID = {"contype": "0", "conaffinity": "1"}
_AIR = {"contype": "0", "conaffinity": "0", "mass": "0"}


def _side(
    base: Xml.Element, rover: Rover, at: tuple[str, float], kind: tuple[Wheels, Steering]
) -> None:
    """The arms and wheels of one side; `at` is its name and its y."""
    (chassis, mobility), (side, y) = _parts(rover), at
    mass = mobility.mass
    places = dict(enumerate((x, y, 0.0) for x in chassis.wheel_x))
    thin = 0.12 * rover.wheel_radius
    if chassis.suspension == "rigid":
        for k, place in places.items():
            _wheel(base, rover, (f"wheel_{side}_{k}", place, (0.0, 0.0, 0.0)), kind)
        return
    pivot = (chassis.rocker[0], y, chassis.rocker[1])
    rocker = _hinged(base, f"rocker_{side}", (pivot, (0.0, 0.0, 0.0)), ROCKER_MASS * mass)
    own, hung = list(places), []
    if chassis.suspension == "rocker-bogie":
        own, hung = ([2], [0, 1]) if chassis.bogie_wheels == "front" else ([0], [1, 2])
    for k in own:
        _arm(rocker, (pivot, pivot), places[k], thin)
        _wheel(rocker, rover, (f"wheel_{side}_{k}", places[k], pivot), kind)
    if hung:
        joint = (chassis.bogie[0], y, chassis.bogie[1])
        _arm(rocker, (pivot, pivot), joint, thin)
        bogie = _hinged(rocker, f"bogie_{side}", (joint, pivot), BOGIE_MASS * mass)
        for k in hung:
            _arm(bogie, (joint, joint), places[k], thin)
            _wheel(bogie, rover, (f"wheel_{side}_{k}", places[k], joint), kind)


Place = tuple[float, float, float]


def _hinged(parent: Xml.Element, name: str, at: tuple[Place, Place], mass: float) -> Xml.Element:
    """A body that turns nose up about its pivot; `at` is the pivot and the parent's own place."""
    body = _add(parent, "body", name=name, pos=_apart(*at))
    _add(body, "joint", name=name, type="hinge", axis="0 -1 0")
    spin = " ".join([str(max(0.01 * mass, 1e-6))] * 3)
    _add(body, "inertial", pos="0 0 0", mass=f"{mass}", diaginertia=spin)
    return body


def _arm(body: Xml.Element, start: tuple[Place, Place], end: Place, thin: float) -> None:
    """What is seen of a rocker or bogie; `start` is where it begins and where its body is."""
    ends = f"{_apart(*start)} {_apart(end, start[1])}"
    _add(body, "geom", type="capsule", fromto=ends, size=f"{thin}", rgba="0.45 0.45 0.48 1", **_AIR)


def _wheel(
    body: Xml.Element, rover: Rover, at: tuple[str, Place, Place], kind: tuple[Wheels, Steering]
) -> None:
    """A wheel; `at` is its name, its place and the place of the body that carries it."""
    (name, place, carrier), (wheels, steering) = at, kind
    (chassis, mobility), r = _parts(rover), rover.wheel_radius
    mass, wide = WHEEL_MASS * mobility.mass, 0.5 * chassis.wheel_width
    wheel = _add(body, "body", name=name, pos=_apart(place, carrier))
    if steering == "corners" and steered_wheels(rover)[wheel_names(rover).index(name)]:
        heavy = 0.04 * mobility.mass * mobility.gravity * r
        _add(wheel, "joint", name=f"steer_{name}", type="hinge", axis="0 0 1", armature=f"{heavy}")
    _add(wheel, "joint", name=name, type="hinge", axis="0 1 0", armature=f"{_geared(rover)}")
    spin = f"{0.25 * mass * r * r} {0.5 * mass * r * r} {0.25 * mass * r * r}"
    _add(wheel, "inertial", pos="0 0 0", mass=f"{mass}", diaginertia=spin)
    size = f"{r}" if wheels == "sphere" else f"{r} {wide}"
    turned = {} if wheels == "sphere" else {"euler": f"{0.5 * math.pi} 0 0"}
    _add(
        wheel, "geom", name=name, type=wheels, size=size, rgba="0.2 0.2 0.22 0", group="3",
        friction="0.8", **_SOLID, **STIFF, **turned,
    )  # fmt: skip
    _add(
        wheel, "geom", type="cylinder", size=f"{r} {wide}", euler=f"{0.5 * math.pi} 0 0",
        rgba="0.2 0.2 0.22 1", **_AIR,
    )  # fmt: skip
    for turn in range(3):  # spokes, so that a picture shows it roll
        _add(
            wheel, "geom", type="box", size=f"{0.8 * r} {1.02 * wide} {0.08 * r}",
            euler=f"0 {turn * math.pi / 3.0} 0", rgba="0.6 0.6 0.62 1", **_AIR,
        )  # fmt: skip


def _motors(root: Xml.Element, whose: tuple[Rover, Mobility], steered: list[str]) -> None:
    """One motor for each wheel, told how fast to turn [rad/s]; strong enough for any ground.

    Then one for each steered wheel, told its angle [rad].
    """
    rover, mobility = whose
    actuator = _add(root, "actuator")
    most = mobility.mass * mobility.gravity * rover.wheel_radius
    gain = _geared(rover) / ANSWER
    for name in wheel_names(rover):
        _add(actuator, "velocity", name=name, joint=name, kv=f"{gain}")
    for name in steered:
        _add(
            actuator, "position", name=f"steer_{name}", joint=f"steer_{name}", kp=f"{20.0 * most}",
            kv=f"{2.0 * most}",
        )  # fmt: skip


def _geared(rover: Rover) -> float:
    """Inertia of a motor as its wheel feels it through the gear [kg m^2]."""
    chassis, mobility = _parts(rover)
    return GEARED * mobility.mass * rover.wheel_radius**2 / chassis.wheels


def _apart(a: Place, b: Place) -> str:
    return " ".join(f"{x - y:.12g}" for x, y in zip(a, b, strict=True))
