"""What whoever takes an arm's FMU must know of it beyond its equations."""

from __future__ import annotations

from stribeck.arm import Joint, unit_at
from stribeck.model.effect import FrictionEffect
from stribeck.model.forward import Forward

ABRUPT = 1e-4  # rad or m: contacts of sharp bends that give way within less stop the solvers of some importers


def notes_of(forward: Forward) -> list[str]:
    """Return the notes on an arm's FMU: limits that it does not know, contacts that Model Exchange may not get over."""
    return [*_limits(forward), *_abrupt(forward)]


def limit_of(joint: Joint) -> str:
    """Return the largest commanded torque of a joint in words; empty where the arm file gives none."""
    return "" if joint.torque_limit is None else f"{joint.torque_limit:g} {unit_at('N m', joint.kind)}"


def _limits(forward: Forward) -> list[str]:
    joints = [joint for joint in forward.path.arm.joints if joint.torque_limit is not None]
    if not joints:
        return []
    limits = ", ".join(f"{joint.name} {limit_of(joint)}" for joint in joints)
    return [f"the FMU does not cut off the command at torque_limit ({limits}): that belongs to what gives it tau"]


def _abrupt(forward: Forward) -> list[str]:
    if forward.delays:
        return []  # there is no Model Exchange
    arm, found = forward.path.arm, []
    for place in forward.path.placed:
        if not (isinstance(place.effect, FrictionEffect) and place.effect.abrupt):
            continue
        joint = arm.joints[place.joint]
        level = max(side.C0 + side.C1 for side in (joint.friction, joint.backward))
        if level < ABRUPT * place.values["stiffness"]:
            found.append(
                f"{joint.name}: {place.effect.label} gives way within {1e3 * ABRUPT:g} {unit_at('mrad', joint.kind)}, "
                "at which the solver of an importer, CVODE say, may stop in Model Exchange: use Co-Simulation"
            )
    return found
