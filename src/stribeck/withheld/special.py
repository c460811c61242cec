"""Hidden effects that change more than one number of the plant."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from stribeck.errors import StribeckError
from stribeck.withheld.plant import Array, Plant

Params = Mapping[str, float]


@dataclass(frozen=True)
class Disturbance:
    """A signal: ``kind`` is ``"torque"`` (N m) or ``"factor"`` (on the friction level)."""

    kind: str
    params: Params

    def signal(self, t: Array, rng: np.random.Generator) -> Array:
        """Return its values at the equally spaced times `t`, s."""
        p = self.params
        if self.kind == "factor":
            return 1.0 + _telegraph(t, p["change"], p["rate"], rng)
        turns = p["frequency"] * t + p["phase"] / (2.0 * math.pi)
        if p["duty"]:  # pulses about their mean, on for so much of a period
            periodic = p["amplitude"] * ((turns % 1.0 < p["duty"]) - p["duty"])
        else:
            periodic = p["amplitude"] * np.sin(2.0 * math.pi * turns)
        return np.asarray(periodic + _coloured(t, p["noise"], p["bandwidth"], rng))


def _coloured(t: Array, size: float, bandwidth: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Gaussian noise of standard deviation `size` behind a first-order low pass of `bandwidth`, Hz (exact sampling)."""
    keep = math.exp(-2.0 * math.pi * bandwidth * (t[1] - t[0]))
    white = rng.standard_normal(len(t))
    white[1:] *= math.sqrt(1.0 - keep**2)
    return np.asarray(size * lfilter([1.0], [1.0, -keep], white))


def _telegraph(t: Array, change: float, rate: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Level between -change and +change that is drawn anew at random times, `rate` a second."""
    jump = rng.random(len(t)) < rate * (t[1] - t[0])
    levels = rng.uniform(-1.0, 1.0, len(t))
    return np.asarray(change * levels[np.maximum.accumulate(np.where(jump, np.arange(len(t)), 0))])


def asymmetric(plant: Plant, k: int, p: Params) -> Plant:
    """Make forward minus backward constants equal `p`; their mean stays."""
    values = {}
    for name in ("C0", "C1", "C2"):
        for side, sign in (("f", 0.5), ("b", -0.5)):
            value = plant.get(k, f"{side}_{name}") + sign * p[name]
            if value < 0.0:
                raise StribeckError(
                    f"asymmetric_friction makes {name} negative", f"{value:g}", "use a smaller difference"
                )
            values[f"{side}_{name}"] = value
    return plant.with_joint(k, **values)


def presliding(plant: Plant, k: int, p: Params) -> Plant:
    """Let elements of total stiffness, N m/rad, and damping, N m s/rad, carry the load before they slide."""
    if math.isinf(p["stiffness"]):
        return plant
    return plant.with_joint(k, bristle_stiffness=p["stiffness"], bristle_damping=p["damping"])


def _outboard_inertia(plant: Plant, k: int) -> float:
    """Inertia of everything beyond joint k about its axis, the chain stretched, kg m^2; mass on an axis that slides."""
    if plant.get_world("prismatic"):
        return plant.get(k, "mass")
    reach, total = 0.0, 0.0
    for i in range(k, plant.n):
        x, y = reach + plant.get(i, "com_x"), plant.get(i, "com_y")
        total += plant.get(i, "inertia") + plant.get(i, "mass") * (x * x + y * y)
        reach += plant.get(i, "length")
    return total


def _rotor(plant: Plant, k: int, effect: str) -> float:
    rotor = plant.get(k, "rotor")
    if rotor <= 0.0:
        raise StribeckError(f"{effect} needs a rotor between motor and link", f"rotor_inertia {rotor}", "give one")
    return rotor


def _shaft_damping(plant: Plant, k: int, stiffness: float, ratio: float) -> float:
    rotor, link = plant.get(k, "rotor"), _outboard_inertia(plant, k)
    return 2.0 * ratio * math.sqrt(stiffness * rotor * link / (rotor + link))


def flexible(plant: Plant, k: int, p: Params) -> Plant:
    """Put a shaft spring between rotor and link; the default damping is 3 % of critical."""
    if math.isinf(p["stiffness"]):
        return plant
    _rotor(plant, k, "joint_flexibility")
    damping = _shaft_damping(plant, k, p["stiffness"], 0.03) if math.isnan(p["damping"]) else p["damping"]
    return plant.with_joint(k, stiffness=p["stiffness"], damping=damping)


def backlash(plant: Plant, k: int, p: Params) -> Plant:
    """Put play of the total width `gap`, rad, with stiff flanks: by default 100 Hz on the rotor, 20 % of critical."""
    if p["gap"] == 0.0:
        return plant
    rotor = _rotor(plant, k, "backlash")
    shaft = plant.get(k, "stiffness")
    stiff = shaft if shaft > 0.0 else rotor * (2.0 * math.pi * 100.0) ** 2
    stiffness = stiff if math.isnan(p["stiffness"]) else p["stiffness"]
    damping = _shaft_damping(plant, k, stiffness, 0.2) if math.isnan(p["damping"]) else p["damping"]
    return plant.with_joint(k, gap=p["gap"], stiffness=stiffness, damping=damping)


def coarse(plant: Plant, k: int, p: Params) -> Plant:
    """Let the encoder resolve no finer than `resolution`, rad."""
    return plant.with_joint(k, resolution=max(plant.get(k, "resolution"), p["resolution"]))


def payload(plant: Plant, k: int, p: Params) -> Plant:
    """Add a mass at the end of link `k`, with an inertia of its own about that point."""
    mass, length = plant.get(k, "mass"), plant.get(k, "length")
    old = complex(plant.get(k, "com_x"), plant.get(k, "com_y"))
    new = (mass * old + p["mass"] * length) / (mass + p["mass"])
    spread = mass * abs(old - new) ** 2 + p["mass"] * abs(length - new) ** 2
    return plant.with_joint(
        k,
        mass=mass + p["mass"],
        com_x=new.real,
        com_y=new.imag,
        inertia=plant.get(k, "inertia") + p["inertia"] + spread,
    )


def tilted(plant: Plant, k: int, p: Params) -> Plant:
    """Change gravity in the arm's plane by (x, y), m/s^2; it belongs to the whole arm, not to joint `k`."""
    x, y = plant.get_world("gravity_x"), plant.get_world("gravity_y")
    return plant.with_world(gravity_x=x + p["x"], gravity_y=y + p["y"])


def soft_base(plant: Plant, k: int, p: Params) -> Plant:
    """Let the base turn about the first axis on a spring; by default as heavy as the arm, 3 % of critical.

    It turns about another point where that is given, its foot, m from the first axis. With a ``direction`` it slides
    instead, as heavy as the arm by default.
    """
    if math.isinf(p["stiffness"]):
        return plant
    _in_plane(plant, "base_flexibility")
    if not math.isnan(p["direction"]):
        arm = sum(plant.get(k, "mass") for k in range(plant.n))
        mass = arm if math.isnan(p["mass"]) else p["mass"]
        damping = 0.06 * math.sqrt(p["stiffness"] * (mass + arm)) if math.isnan(p["damping"]) else p["damping"]
        return plant.with_world(
            slide_stiffness=p["stiffness"], slide_damping=damping, slide_mass=mass, slide_direction=p["direction"]
        )
    arm = _outboard_inertia(plant, 0)
    inertia = arm if math.isnan(p["inertia"]) else p["inertia"]
    damping = 0.06 * math.sqrt(p["stiffness"] * (inertia + arm)) if math.isnan(p["damping"]) else p["damping"]
    foot = {name: 0.0 if math.isnan(p[name]) else p[name] for name in ("foot_x", "foot_y")}
    return plant.with_world(base_stiffness=p["stiffness"], base_damping=damping, base_inertia=inertia, **foot)


def _in_plane(plant: Plant, effect: str) -> None:
    if plant.get_world("prismatic"):
        raise StribeckError(f"{effect} needs an arm that turns", "an axis that slides", "leave it out")


def wall(plant: Plant, k: int, p: Params) -> Plant:
    """Put a wall in the way of joint `k`, rad, or, with a ``direction`` of its normal, of the arm's tip, m."""
    if math.isnan(p["direction"]):
        names = ("stiffness", "position", "side", "damping", "exponent", "damper")
        return plant.with_joint(k, **{f"wall_{name}": p[name] for name in names})
    _in_plane(plant, "contact")
    return plant.with_world(
        plane_direction=p["direction"], plane_distance=p["position"], plane_stiffness=p["stiffness"],
        plane_damping=p["damping"], plane_exponent=p["exponent"],
    )  # fmt: skip


def sloshing(plant: Plant, k: int, p: Params) -> Plant:
    """Let a part of the link's mass swing on a short pendulum with a weak spring; at rest nothing changes."""
    if p["mass"] == 0.0:
        return plant
    _in_plane(plant, "sloshing_mass")
    mass, length = plant.get(k, "mass"), plant.get(k, "length")
    arm = 0.5 * length if math.isnan(p["arm"]) else p["arm"]
    swing = 0.2 * length if math.isnan(p["length"]) else p["length"]
    own = p["mass"] * swing**2
    stiffness = own * (2.0 * math.pi * 2.0) ** 2 if math.isnan(p["stiffness"]) else p["stiffness"]
    damping = 0.1 * math.sqrt(own * stiffness) if math.isnan(p["damping"]) else p["damping"]
    old = complex(plant.get(k, "com_x"), plant.get(k, "com_y"))
    left = mass - p["mass"]
    new = (mass * old - p["mass"] * (arm + swing)) / left if left > 0.0 else old
    inertia = plant.get(k, "inertia") - left * abs(new - old) ** 2 - p["mass"] * abs(arm + swing - old) ** 2
    if left <= 0.0 or inertia <= 0.0:
        raise StribeckError("sloshing_mass takes more than the link has", f"{p['mass']:g} kg", "use a smaller mass")
    return plant.with_joint(
        k, mass=left, com_x=new.real, com_y=new.imag, inertia=inertia, slosh_mass=p["mass"], slosh_arm=arm,
        slosh_length=swing, slosh_stiffness=stiffness, slosh_damping=damping,
    )  # fmt: skip


def tendon(plant: Plant, k: int, p: Params) -> Plant:
    """Run a cable from joint `k` to the next one (the last: to the one before), which only pulls."""
    if plant.n == 1 and p["stiffness"] > 0.0:
        raise StribeckError("tendon_coupling needs a second joint", "1 joint", "record a longer arm")
    return plant.with_joint(k, tendon_stiffness=p["stiffness"], tendon_ratio=p["ratio"], tendon_slack=p["slack"])
