"""The recording plant as a value: a table of physical parameters, and the call that runs it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm, Joint
from stribeck.errors import StribeckError
from stribeck.withheld.build import library

Array: TypeAlias = NDArray[np.float64]
STEP = 4e-5  # s, longest internal step; see tests/withheld/test_plant.py for its error
MAX_JOINTS = 4
MEMORY = 16000  # steps of past speed that the plant can look back on
MAX_FRICTION_LAG = 0.2  # s, bounded by the plant's memory of past speed


class Diverged(StribeckError):
    """The arm swings up: the controller cannot hold it."""


@dataclass(frozen=True)
class Plant:
    """Physical parameters of an arm and of everything around it.

    Attributes
    ----------
    world : (fields,) array
        Gravity and base; `world_fields` names the columns.
    joints : (n, fields) array
        One row a joint; `joint_fields` names the columns. SI units.
    """

    world: Array
    joints: Array

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    def get(self, k: int, field: str) -> float:
        """Return one parameter of joint `k`."""
        return float(self.joints[k, joint_fields()[field]])

    def get_world(self, field: str) -> float:
        """Return one parameter of base and gravity."""
        return float(self.world[world_fields()[field]])

    def with_joint(self, k: int, **values: float) -> Plant:
        """Return a plant whose joint `k` has the parameters `values`."""
        joints = self.joints.copy()
        for name, value in values.items():
            joints[k, joint_fields()[name]] = value
        return replace(self, joints=joints)

    def with_world(self, **values: float) -> Plant:
        """Return a plant with the parameters `values` of base and gravity."""
        world = self.world.copy()
        for name, value in values.items():
            world[world_fields()[name]] = value
        return replace(self, world=world)


@dataclass(frozen=True)
class Drive:
    """What drives one recording: all arrays start at the first recorded sample.

    Attributes
    ----------
    period : float
        Sample time, s.
    reference : (N, n, 2) array
        Position and velocity that the controller wants, rad, rad/s.
    forward, noise : (N, n) array
        Feedforward torque, N m; encoder noise, rad.
    push, factor : (N * fine + 1, n) array
        Torque from outside, N m, and factor on the friction level, linear between points.
    start : (n, 2) array
        Angle and rate at the start, rad, rad/s.
    warmth : (n,) array
        State of the warm-up, or of the wear, at the start.
    substeps : int
        Internal steps a sample; 0 takes as many as `STEP` asks for.
    """

    period: float
    reference: Array
    forward: Array
    noise: Array
    push: Array
    factor: Array
    start: Array
    warmth: Array
    substeps: int = 0


@dataclass(frozen=True)
class Trace:
    """What was recorded, and what was true.

    Attributes
    ----------
    q, tau, dq : (N, n) array
        Encoder, rad; command, N m; velocity of the drive's own estimator, rad/s.
    motor, motor_rate, link, link_rate : (N, n) array
        True angles and rates on both sides of the transmission, rad, rad/s.
    friction, torque, load : (N, n) array
        Friction (opposing), torque of the rotor and torque passed on to the link in the step before, N m.
    warmth : (n,) array
        State of the warm-up, or of the wear, at the end.
    """

    q: Array
    tau: Array
    dq: Array
    motor: Array
    motor_rate: Array
    link: Array
    link_rate: Array
    friction: Array
    torque: Array
    load: Array
    warmth: Array


@cache
def joint_fields() -> dict[str, int]:
    """Names of a joint's parameters, in the order of the compiled plant."""
    return {name: i for i, name in enumerate(library().plant_joint_fields().decode().split())}


@cache
def world_fields() -> dict[str, int]:
    """Names of the parameters of base and gravity, in the order of the compiled plant."""
    return {name: i for i, name in enumerate(library().plant_world_fields().decode().split())}


def plant_of(arm: Arm) -> Plant:
    """Return the plant of an arm without any effect beyond Tustin friction.

    Raises
    ------
    StribeckError
        When the arm has more than four joints.
    """
    if arm.n > MAX_JOINTS:
        raise StribeckError("the recording plant takes at most 4 joints", str(arm.n), "record a shorter chain")
    plant = Plant(np.zeros(len(world_fields())), np.zeros((arm.n, len(joint_fields()))))
    plant = plant.with_world(
        prismatic=float(arm.joints[0].kind == "prismatic"), gravity_x=arm.gravity[0], gravity_y=arm.gravity[1]
    )
    for k, joint in enumerate(arm.joints):
        plant = plant.with_joint(k, **_values(joint))
    return plant


def _values(joint: Joint) -> dict[str, float]:
    rigid = {
        "length": joint.length,
        "mass": joint.mass,
        "com_x": joint.com[0],
        "com_y": joint.com[1],
        "inertia": joint.inertia,
        "rotor": joint.rotor_inertia,
    }
    friction = {
        f"{side}_{name}": getattr(constants, name)
        for side, constants in (("f", joint.friction), ("b", joint.backward))
        for name in ("C0", "C1", "C2", "alpha")
    }
    return {
        **rigid,
        **friction,
        "gain": 1.0,
        "saturation": math.inf,
        "resolution": joint.encoder_resolution or 0.0,
        "torque_limit": joint.torque_limit or 0.0,
    }


def simulate(plant: Plant, drive: Drive) -> Trace:
    """Run the plant under its sampled controller.

    Raises
    ------
    Diverged
        When the motion diverges or the mass matrix is not positive.
    """
    samples, n = drive.forward.shape
    substeps = drive.substeps or math.ceil(drive.period / STEP - 1e-9)
    fine = (len(drive.push) - 1) // samples
    truth = np.empty((samples, n, library().plant_truth_width()))
    q, tau, dq = np.empty((samples, n)), np.empty((samples, n)), np.empty((samples, n))
    warmth = np.array(drive.warmth, dtype=np.float64)
    inputs = [drive.reference, drive.forward, drive.noise, drive.push, drive.factor, drive.start]
    arrays = [*(np.ascontiguousarray(a, dtype=np.float64) for a in inputs), warmth, q, tau, dq, truth]
    reach = joint_fields()["friction_lag"]
    if np.any(plant.joints[:, reach] * substeps / drive.period > MEMORY):
        raise StribeckError(
            "the internal step is too short for the frictional lag", str(substeps), "take fewer substeps"
        )
    world, joints = np.ascontiguousarray(plant.world), np.ascontiguousarray(plant.joints)
    status = library().plant_record(
        world.ctypes.data,
        joints.ctypes.data,
        n,
        samples,
        substeps,
        fine,
        drive.period,
        *(a.ctypes.data for a in arrays),
    )
    if status != 0:
        why = {1: "the motion diverged", 2: "the mass matrix is not positive", 3: "no memory left"}[status]
        raise Diverged(f"the recording stopped: {why}", "", "lower the controller gains or check the arm")
    motor, motor_rate, link, link_rate, friction, torque, load = np.moveaxis(truth, 2, 0)
    return Trace(q, tau, dq, motor, motor_rate, link, link_rate, friction, torque, load, warmth)


def rigid_torque(arm: Arm, q: Array, dq: Array, ddq: Array) -> Array:
    """Return the torque (N, n) that the arm without friction needs along a motion (N, n), N m."""
    plant = plant_of(arm)
    motion = [np.ascontiguousarray(a, dtype=np.float64) for a in (q, dq, ddq)]
    torque = np.empty_like(motion[0])
    library().plant_inverse(
        plant.world.ctypes.data, plant.joints.ctypes.data, plant.n, len(torque), *(a.ctypes.data for a in motion),
        torque.ctypes.data,
    )  # fmt: skip
    return torque
