"""MuJoCo's system identification toolbox on a case: what its user would fit, and what its report then says."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stdout
from typing import Any

import numpy as np
from _rival import Answer, friction_intervals

from stribeck.arm import Arm, Joint
from stribeck.gap.records.prepare import Prepared
from stribeck.identify.conditioning import Conditioned, condition

WINDOW = 1.0  # s of open-loop simulation from a recorded state: longer ones drift off
LONGEST_STEP = 0.002  # s
BOUNDS = (0.1, 10.0)  # of the nominal value
ITERATIONS = 10
DELAYS = (-0.02, 0.05)  # s, of a sensor
MEANS = {"stiffness": "cable_spring", "offset": "torque_offset", "delay": "time_shift"}
ALIKE = {"time_shift": "delay"}  # a delay of sensors is all that the toolbox has for either


def by_mujoco(arm: Arm, prepared: Prepared, *, extended: bool = False) -> Answer:
    """Fit masses (inertias in proportion), armatures, damping and dry friction, as its examples do.

    Centres and inertias of their own beside them leave it without finite intervals, as it knows no priors. Windows
    start from the smoothed record, and the toolbox gets the command as the zero-order hold that it is, so that no
    shift of half a sample is its fault.

    Parameters
    ----------
    extended : bool
        Whether a spring and an offset of the motor at each joint, and a delay of its sensor, are fitted along: what
        the toolbox has for effects. Those whose interval excludes nothing are then read as names.
    """
    from mujoco import sysid
    from mujoco.sysid.report.sections.insights import AutomatedInsights

    sample = min(run.run.sample_time for run in prepared.fit)
    step = sample / math.ceil(sample / LONGEST_STEP - 1e-9)
    sequences = _sequences(sysid, _spec(arm, step), [condition(arm, r.run, prepared.cutoff, r.noise)
                                                     for r in prepared.fit], step)  # fmt: skip
    parameters, transform = _parameters(sysid, arm), sysid.SignalTransform()
    for joint, scale in zip(arm.joints, prepared.scales, strict=True):
        for parameter in _extra(sysid, joint.name, scale.torque) if extended else ():
            parameters.add(parameter)
        if extended:
            transform.delay(joint.name, parameters[f"{joint.name}.delay"])
    residual = sysid.build_residual_fn(models_sequences=[sequences], build_model=sysid.apply_param_modifiers,
                                       modify_residual=transform.apply if extended else None, n_threads=1)  # fmt: skip
    parameters.move_off_bounds()  # as the toolbox advises where a spring starts from none
    with redirect_stdout(io.StringIO()):  # its log of every iteration has no switch
        fitted, found = sysid.optimize(
            parameters, residual, optimizer="mujoco", verbose=False, max_iters=ITERATIONS, x_scale="jac"
        )
    left, _, _ = residual(fitted.as_vector(), fitted)
    _, half = sysid.calculate_intervals(left, found.jac)
    insights = AutomatedInsights("", fitted).get_context()["insights"]
    alarms = [row["title"] for row in insights if row["type"] == "warning"]
    at = dict(zip(fitted.get_non_frozen_parameter_names(), zip(fitted.as_vector(), half, strict=True), strict=True))
    rows = [at[_name(joint, field)] for joint in arm.joints for field in ("frictionloss", "damping")]
    says = "a value at a bound" if alarms else "No Issues Detected"
    named = _surely_there(at, arm.names) if extended else ()
    alike = (ALIKE[named[0][0]],) if named and named[0][0] in ALIKE else ()
    return Answer(named, None, friction_intervals(arm, rows), says, alike=alike)


def _extra(sysid: Any, joint: str, torque: float) -> list[Any]:
    """Return the parameters of a joint beyond rigid bodies and friction; all are 0 at first."""
    return [
        sysid.Parameter(f"{joint}.stiffness", 0.0, 0.0, torque, modifier=_into_joint(joint, "stiffness")),
        sysid.Parameter(f"{joint}.offset", 0.0, -torque, torque, modifier=_into_motor(joint)),
        sysid.Parameter(f"{joint}.delay", 0.0, *DELAYS),
    ]


def _surely_there(at: Mapping[str, tuple[float, float]], joints: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Return (effect, joint) whose interval excludes 0, the surest first."""
    found = []
    for joint in joints:
        for field, effect in MEANS.items():
            value, half = at[f"{joint}.{field}"]
            found.append((abs(value) / max(half, 1e-300), effect, joint))
    return tuple((effect, joint) for ratio, effect, joint in sorted(found, reverse=True) if ratio > 1.0)


def _spec(arm: Arm, step: float) -> Any:
    import mujoco

    closing = "</body>" * arm.n
    bodies, place = "", 0.0
    for joint in arm.joints:
        i = joint.inertia
        bodies += (
            f'<body name="{joint.name}" pos="{place} 0 0"><joint name="{joint.name}" axis="0 0 1" '
            f'armature="{joint.rotor_inertia}" damping="{joint.friction.C2}" frictionloss="{joint.friction.C0}"/>'
            f'<inertial pos="{joint.com[0]} {joint.com[1]} 0" mass="{joint.mass}" diaginertia="{i} {i} {i}"/>'
        )
        place = joint.length
    motors = "".join(f'<general name="{joint.name}" joint="{joint.name}" biastype="affine"/>' for joint in arm.joints)
    sensors = "".join(f'<jointpos name="{joint.name}" joint="{joint.name}"/>' for joint in arm.joints)
    gravity = f"{arm.gravity[0]} {arm.gravity[1]} 0"
    return mujoco.MjSpec.from_string(
        f'<mujoco><compiler balanceinertia="true"/><option timestep="{step}" gravity="{gravity}" '
        f'integrator="implicitfast"><flag contact="disable"/></option><worldbody>{bodies}{closing}</worldbody>'
        f"<actuator>{motors}</actuator><sensor>{sensors}</sensor></mujoco>"
    )


def _sequences(sysid: Any, spec: Any, runs: Sequence[Conditioned], step: float) -> Any:
    model = spec.compile()
    names, states, controls, records = [], [], [], []
    for run in runs:
        length = round(WINDOW / run.sample_time)
        for first in range(0, len(run.time) - length, length):
            rows = slice(first, first + length + 1)
            t = run.time[rows] - run.time[first]
            fine = np.arange(round(t[-1] / step) + 1) * step
            held = run.run.tau[rows][np.clip(np.searchsorted(t, fine + 1e-9) - 1, 0, length)]
            names.append(f"{run.name} {first}")
            states.append(sysid.create_initial_state(model, run.position[first], run.velocity[first]))
            controls.append(sysid.TimeSeries.from_control_names(fine, held, model))
            records.append(sysid.TimeSeries.from_names(t, run.run.q[rows], model))
    return sysid.ModelSequences("arm", spec, names, states, controls, records)


def _name(joint: Joint, field: str) -> str:
    return f"{joint.name}.{field}"


def _parameters(sysid: Any, arm: Arm) -> Any:
    """Return the parameters, bounded as the toolbox bounds masses by default, and how each is written into a model."""
    out = sysid.ParameterDict()
    for joint in arm.joints:
        values = {"mass": joint.mass, "armature": joint.rotor_inertia, "frictionloss": joint.friction.C0}
        for field, value in {**values, "damping": joint.friction.C2}.items():
            put = _into_body(joint.name) if field == "mass" else _into_joint(joint.name, field)
            low, high = (bound * max(value, 1e-6) for bound in BOUNDS)
            out.add(sysid.Parameter(_name(joint, field), value, low, high, modifier=put))
    return out


def _into_body(name: str) -> Callable[[Any, Any], None]:
    def put(spec: Any, parameter: Any) -> None:
        body = spec.body(name)
        body.inertia = np.asarray(body.inertia) * parameter.value[0] / body.mass
        body.mass = parameter.value[0]

    return put


def _into_joint(name: str, field: str) -> Callable[[Any, Any], None]:
    def put(spec: Any, parameter: Any) -> None:
        joint, value = spec.joint(name), parameter.value[0]
        before = getattr(joint, field)
        setattr(joint, field, value if np.ndim(before) == 0 else [value, *list(before)[1:]])

    return put


def _into_motor(name: str) -> Callable[[Any, Any], None]:
    def put(spec: Any, parameter: Any) -> None:
        bias = np.array(spec.actuator(name).biasprm)
        bias[0] = parameter.value[0]
        spec.actuator(name).biasprm = bias

    return put
