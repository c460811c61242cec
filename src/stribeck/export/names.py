"""Names, descriptions and bounds of an FMU's parameters, from those of the arm file."""

from __future__ import annotations

import casadi as ca

from stribeck.model.forward import Forward
from stribeck.model.layout import Entry

_LIGHTEST = 1e-6  # kg m^2, of a rotor that drives a spring: without inertia none can turn there

_DESCRIBED = {
    "mass": "mass of the link",
    "com_x": "centre of mass along the link",
    "com_y": "centre of mass across the link",
    "inertia": "moment of inertia about the centre of mass",
    "rotor_inertia": "rotor inertia, reflected to the joint",
    "C0": "Coulomb friction",
    "C1": "break-away above Coulomb friction",
    "C2": "viscous friction",
    "alpha": "speed over which friction falls to Coulomb's",
}


def parameter_name(forward: Forward, entry: Entry) -> str:
    """Return the FMU's name of a model parameter, as in the arm file: ``joint[1].friction.C0``."""
    joint = entry.joint + 1
    if isinstance(entry.owner, int):
        return f"{effect_prefix(forward, entry.owner)}.{entry.name}"
    if entry.owner == "friction":
        side = "friction.backward" if ".backward." in entry.key else "friction"
        return f"joint[{joint}].{side}.{entry.name}"
    axis = {"com_x": "com[1]", "com_y": "com[2]"}
    return f"joint[{joint}].{axis.get(entry.name, entry.name)}"


def effect_prefix(forward: Forward, k: int) -> str:
    """Return ``effect.NAME[JOINT]`` of the k-th placed effect; a second one of a name there is ``NAME_2``."""
    placed = forward.path.placed
    place = placed[k]
    same = [i for i, p in enumerate(placed) if p.key == place.key]
    suffix = f"_{same.index(k) + 1}" if same.index(k) else ""
    return f"effect.{place.effect.name}{suffix}[{place.joint + 1}]"


def parameter_description(forward: Forward, entry: Entry) -> str:
    """Return what a model parameter is, in words."""
    name = forward.path.arm.names[entry.joint]
    if not isinstance(entry.owner, int):
        return f"{_DESCRIBED.get(entry.name, entry.name)} of joint {name}"
    effect = forward.path.placed[entry.owner].effect
    described = {p.name: p.description for p in effect.parameters}[entry.name]
    return f"{described} (effect {effect.name}, joint {name})"


def bounds(forward: Forward, entry: Entry) -> tuple[float, float]:
    """Return the bounds of a parameter; its own value always lies within them, and no delay looks ahead."""
    delays = {forward.path.entries[i].key for _, i in forward.delays}
    lower = max(entry.lower, 0.0) if entry.key in delays else entry.lower
    if entry.name == "rotor_inertia" and entry.owner == "inertial" and entry.joint in forward.path.flexible:
        lower = _LIGHTEST
    return min(lower, entry.value), max(entry.upper, entry.value)


def starting(forward: Forward) -> frozenset[int]:
    """Return the places in p of what says how a simulation starts, or what came before, and has no part in its motion.

    A late command acts outside of the equations, and so does what a ``direct`` effect does to a record.
    """
    path = forward.path
    moved = ca.vertcat(forward.rates, forward.margins, *forward.outputs(*forward.inputs))
    acts = ca.which_depends(moved, path.p, 1, False)
    late = {i for _, i in forward.delays}
    return frozenset(
        i
        for i, entry in enumerate(path.entries)
        if isinstance(entry.owner, int) and not (acts[i] or i in late or path.placed[entry.owner].effect.direct)
    )
