"""Diagnoses to draw: realistic signals of an arm with presliding, for each verdict and size."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint
from stribeck.gap.result import Candidate, Cause, Diagnosis, Estimate, Place, Recording, Region, Stage, Trace, Tuned
from stribeck.report import write_report

RATE = 200.0
EFFECTS = (
    "presliding", "backlash", "position_dependent_friction", "asymmetric_friction", "load_dependent_friction",
    "actuator_lag", "delay", "torque_gain", "joint_flexibility", "encoder_eccentricity", "payload", "gravity_tilt",
    "cable_spring",
)  # fmt: skip


def make_arm(joints, kind="revolute", effects=()):
    friction = Friction(4.6, 1.65, 1.4, 0.06)
    return Arm(
        "two-link direct-drive arm",
        (0.0, 0.0),
        tuple(Joint(name, kind, 0.35, 4.0, (0.17, 0.0), 0.06, 0.15, friction, friction) for name in joints),
        effects=effects,
    )


def _motion(n, time, seed):
    rng = np.random.default_rng(seed)
    q = np.zeros((len(time), n))
    v, a = q.copy(), q.copy()
    for j in range(n):
        for k in range(3):
            omega, size, phase = rng.uniform(0.8, 4.0), rng.uniform(0.2, 0.6) / (k + 1), rng.uniform(0, 6.28)
            q[:, j] += size * np.sin(omega * time + phase)
            v[:, j] += size * omega * np.cos(omega * time + phase)
            a[:, j] -= size * omega**2 * np.sin(omega * time + phase)
    return q, v, a


def _bristle(v, level, stiffness):
    b = np.zeros_like(v)
    for i in range(1, len(v)):
        rate = stiffness * (v[i] - abs(v[i]) * b[i - 1] / level)
        b[i] = np.clip(b[i - 1] + rate / RATE, -level, level)
    return b


def make_trace(n, run, seed, gap=True, duration=9.0):
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, duration, 1 / RATE)
    q, v, a = _motion(n, time, seed)
    size = 0.6 ** np.arange(n)
    level = 4.6 * size
    inertia = 0.8 * size
    sliding = inertia * a + 1.4 * size * v + level * np.tanh(v / 0.004)
    bristle = inertia * a + 1.4 * size * v + _bristle(v, level, 400.0 * size)
    noise = np.cumsum(rng.normal(0, 0.02, (len(time), n)), axis=0)
    noise = (noise - np.array([np.convolve(c, np.ones(41) / 41, "same") for c in noise.T]).T) * size
    measured = (bristle if gap else sliding) + noise
    nominal = 1.2 * inertia * a + 0.9 * size * v + 0.8 * level * np.tanh(v / 0.004)
    corrected = bristle + 0.05 * size * np.sin(2 * q) if gap else sliding
    return Trace(run, time, q, v, measured, nominal, sliding, corrected)


def _rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def _family_masks(v, a, q, t):
    edges = np.quantile(q, [0, 0.25, 0.5, 0.75, 1.0])
    near = np.convolve(np.abs(np.diff(np.sign(v), prepend=np.sign(v[0]))), np.ones(31), "same") > 0
    speed = np.abs(v)
    low, high = np.quantile(speed, [0.4, 0.75])
    yield "motion", "velocity reversal", near
    yield "motion", "low velocity", ~near & (speed <= low)
    yield "motion", "medium velocity", ~near & (speed > low) & (speed <= high)
    yield "motion", "high velocity", ~near & (speed > high)
    yield "direction", "forward", v > 0
    yield "direction", "backward", v <= 0
    for k in range(4):
        last = (q <= edges[k + 1]) if k == 3 else (q < edges[k + 1])
        yield "position", f"{edges[k]:.2f} to {edges[k + 1]:.2f} rad", (q >= edges[k]) & last
    big = np.abs(a) > np.median(np.abs(a))
    yield "acceleration", "low acceleration", ~big
    yield "acceleration", "high acceleration", big
    third = t[-1] / 3
    yield "time", "first third", t < third
    yield "time", "second third", (t >= third) & (t < 2 * third)
    yield "time", "last third", t >= 2 * third


def _part(share, part):
    return Estimate(part * share.value, part * share.low, part * share.high)


def make_regions(joints, traces):
    stack = {name: np.concatenate([getattr(x, name) for x in traces]) for name in Trace.__dataclass_fields__
             if name not in ("run", "time")}  # fmt: skip
    t = np.concatenate([x.time for x in traces])
    a = np.gradient(stack["velocity"], 1 / RATE, axis=0)
    regions = []
    for j, joint in enumerate(joints):
        before, after = ((stack["measured"] - stack[m])[:, j] for m in ("retuned", "corrected"))
        for family, name, mask in _family_masks(stack["velocity"][:, j], a[:, j], stack["position"][:, j], t):
            share = float(np.sum(before[mask] ** 2) / np.sum(before**2))
            estimate = Estimate(share, max(0.0, share - 0.06), min(1.0, share + 0.05))
            regions.append(
                Region(joint, family, name, estimate, float(mask.mean()), _rms(before[mask]), _rms(after[mask]))
            )
    return tuple(regions)


def make_candidates(joints, count, partner):
    rng = np.random.default_rng(5)
    names = [(e, j) for e in EFFECTS for j in joints][:count] or []
    rows = []
    for step in (1, 2):
        for k, (effect, joint) in enumerate(names):
            if step == 2 and k == 0:
                continue
            gain = 0.91 if k == 0 else 0.895 if effect == partner and joint == joints[0] else rng.normal(0.1, 0.15)
            gain = gain if step == 1 else 0.1 * rng.normal()
            half = 0.02 + 0.05 * rng.random()
            status = "Solve_Succeeded" if k % 7 != 5 else "Maximum_Iterations_Exceeded"
            status = "screened out" if k > 8 and k % 3 else status
            value = Estimate(0.0, 0.0, 0.0) if status == "screened out" else None
            estimate = value or Estimate(gain, gain - half, gain + half)
            rows.append(Candidate(step, effect, joint, estimate, gain / half, status, step == 1 and k == 0))
    return tuple(rows)


def make_tuned(joints):
    rows = []
    for j, joint in enumerate(joints):
        rows += [
            Tuned(f"{joint}.mass", "kg", 4.0, 0.2, Estimate(4.02, 3.7, 4.3), identified=False),
            Tuned(f"{joint}.com_x", "m", 0.17, 0.0085, Estimate(0.1432, 0.1418, 0.1446), at_limit=j == 0),
            Tuned(f"{joint}.inertia", "kg m^2", 0.06, 0.003, Estimate(0.0613, 0.0601, 0.0625)),
            Tuned(f"{joint}.C0", "N m", 4.6, 1.38, Estimate(5.214, 5.13, 5.3)),
            Tuned(f"{joint}.alpha", "rad/s", 0.06, 0.018, Estimate(0.0712, 0.0634, 0.079)),
        ]
    return tuple(rows)


def _stages(joints, traces, verdict, named):
    def torque(model):
        errors = np.concatenate([x.measured - getattr(x, model) for x in traces])
        return {joint: _rms(errors[:, j]) for j, joint in enumerate(joints)}

    floor = {joint: 0.055 * 0.6**j for j, joint in enumerate(joints)}
    torques = [("as_given", torque("nominal")), ("retuned", torque("retuned"))]
    start = torques[-1][1]
    end = torque("corrected") if verdict == "explained" else {joint: 0.5 * start[joint] for joint in joints}
    for k, name in enumerate(named):
        part = (k + 1) / len(named)
        torques.append((name, {joint: start[joint] ** (1 - part) * end[joint] ** part for joint in joints}))
    torques.append(("noise_floor", {joint: min(floor[joint], 0.98 * start[joint]) for joint in joints}))
    motion = 0.011
    return tuple(Stage(name, values, {joint: motion * value for joint, value in values.items()})
                 for name, values in torques)  # fmt: skip


def _causes(verdict, named, joints, equivalent):
    if verdict == "no_gap":
        return (Cause("none", 0.964), Cause("unknown", 0.021), Cause("presliding", 0.015, (joints[0],)))
    if not named:
        return (Cause("unknown", 0.82), Cause("backlash", 0.11, (joints[0],)), Cause("delay", 0.07, (joints[-1],)))
    main = Cause(
        named[0], 0.97 if len(equivalent) == 1 else 0.55, (joints[0],), equivalent,
        {joints[0]: {"stiffness": Estimate(1502.31, 1411.2, 1594.0, "N m/rad"),
                     "damping": Estimate(4.81, 0.0, 9.7, "N m s/rad")}},
        Estimate(0.913, 0.882, 0.934),
    )  # fmt: skip
    more = [Cause(e, 0.42 / (len(equivalent) - 1), (joints[0],), equivalent) for e in equivalent if e != named[0]]
    for name in named[1:]:
        spring = {joints[-1]: {"stiffness": Estimate(12.7, 11.9, 13.4, "N m/rad")}}
        more.append(Cause(name, 0.9, (joints[-1],), (name,), spring, Estimate(0.31, 0.22, 0.40)))
    rest = Cause("unknown", 0.03)
    return (main, *more, rest)


@cache  # frozen, and slow to make up
def make_diagnosis(verdict="explained", joints=("A", "B"), candidates=26, equivalent=("presliding",),
                   named=None, arm="two-link direct-drive arm", runs=None, duration=9.0, kind="revolute"):  # fmt: skip
    gap = verdict != "no_gap"
    named = named if named is not None else ("presliding",) if verdict in ("explained", "partly_explained") else ()
    runs = runs or ("run_04.csv", "run_05.csv")
    traces = tuple(make_trace(len(joints), run, 11 + k, gap, duration) for k, run in enumerate(runs))
    if not named:
        traces = tuple(Trace(x.run, x.time, x.position, x.velocity, x.measured, x.nominal, x.retuned, x.retuned)
                       for x in traces)  # fmt: skip
    regions = make_regions(joints, traces)
    top = sorted((r for r in regions if r.family == "motion"), key=lambda r: -r.share.value)[:4]
    places = tuple(Place(r.joint, "friction", r.region, _part(r.share, 1 / len(joints))) for r in top)
    partly = Estimate(0.52, 0.41, 0.6) if named else None
    limit = f"{joints[0]}.com_x: the data push it to three standard deviations of its tolerance"
    further = {
        "what": "micro-amplitude reversals",
        "joint": joints[0],
        "separates": ["presliding", "backlash"],
        "amplitude": {"value": 0.002, "unit": "rad"},
    }
    partner = equivalent[-1] if len(equivalent) > 1 else ""
    entries = (EffectEntry("presliding", (joints[0],), {joints[0]: {"stiffness": 1500.0, "damping": 5.0}}),)
    nominal = make_arm(joints, kind)
    return Diagnosis(
        arm=arm,
        joints=tuple(joints),
        fit_runs=("run_00.csv", "run_01.csv", "run_02.csv", "run_03.csv"),
        held_out_runs=tuple(runs),
        verdict=verdict,
        named=tuple(named),
        horizon=0.5,
        stages=_stages(joints, traces, verdict, named),
        closed=Estimate(0.913, 0.882, 0.934) if verdict == "explained" else partly,
        where=places if gap else (),
        regions=regions,
        causes=_causes(verdict, named, joints, equivalent),
        candidates=make_candidates(joints, candidates, partner) if gap else (),
        tuned=make_tuned(joints),
        traces=traces,
        recordings=tuple(
            Recording(run, run in runs, joint, 0.5 if gap else 0.11, 0.12 if named else 0.5, 0.1)
            for run in ("run_00.csv", *runs) for joint in joints
        ),
        models={"as_given": nominal, "retuned": nominal, "corrected": make_arm(joints, kind, entries if named else ())},
        notes=("time aligned to 0.02 samples", "noise floor from the part above 30 Hz"),
        warnings=(limit,) if gap else (),
        next_experiment=further if len(equivalent) > 1 else None,
        settings={"filter": 25.0, "filter_unit": "Hz", "seed": 0.0},
    )  # fmt: skip


@pytest.fixture
def diagnosis():
    """The factory itself: each test asks for the diagnosis that it needs."""
    return make_diagnosis


HOSTILE = "$\\frac{$<img src=x onerror=alert(1)>\x1b[31m[bold]"


@pytest.fixture(scope="session")
def written(tmp_path_factory):
    """Return (diagnosis, folder) of a report, written once for all tests that read it.

    Where not ``drawn`` its figures are laid out but not made into images, which takes most of the time.
    """
    made = {}
    cases = {
        "no_gap": lambda: make_diagnosis("no_gap", duration=4.0),
        "explained": lambda: make_diagnosis(candidates=12, duration=4.0),
        "class": lambda: make_diagnosis(candidates=12, equivalent=("presliding", "backlash"), duration=4.0),
        "partly_explained": lambda: make_diagnosis("partly_explained", joints=("J1",), kind="prismatic", candidates=8),
        "unexplained": lambda: make_diagnosis("unexplained", candidates=6, duration=4.0),
        "single": lambda: replace(
            make_diagnosis(joints=("A",), candidates=6, runs=("run_00.csv",), duration=4.0), fit_runs=("run_00.csv",)
        ),
        "hostile": lambda: make_diagnosis(
            joints=(HOSTILE, f"B{HOSTILE}"), arm=HOSTILE, runs=(HOSTILE,), candidates=6, duration=4.0
        ),
    }

    def write(case, drawn=True):
        if (case, True) in made:
            return made[case, True]
        if (case, drawn) not in made:
            folder = tmp_path_factory.mktemp(case)
            made[case, drawn] = cases[case](), folder
            with pytest.MonkeyPatch.context() as patch:
                if not drawn:
                    patch.setattr("stribeck.report.diagnosis.png_and_svg", lambda figure: (b"", b""))
                write_report(*made[case, drawn])
        return made[case, drawn]

    return write
