"""Every effect, recorded by the independent plant and fitted by the library: its parameters come back.

The plant shares no law with the library. Where the two differ on purpose (presliding: Iwan's elements against one
bristle; backlash: another contact; dwell time, warm-up and frictional lag: other states) only some parameters can
be compared, and the residual must fall.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from stribeck.effects.registry import effect_named, laws
from stribeck.gap.fitted.differentiable import differentiable
from stribeck.gap.fitted.model import Model, fit_model, retune, start_values, weights_of
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search.screen import screen
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath

from .bench import nominal_arm, recorded, scaled

FLOOR = np.full(2, 0.01)  # N m


@dataclass(frozen=True)
class Case:
    """What is hidden where, and what must come back.

    ``expected`` holds value and allowance by the library's parameter names; ``left`` the part of the joint's
    residual that may be left, rms, after so many ``rounds`` of weights and fit.
    """

    joint: str
    hidden: Mapping[str, float]
    expected: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    left: float = 0.5
    rounds: int = 1
    elsewhere: str = ""  # the same at another joint


def wave(amplitude: float, phase: float, harmonic: float, allowed: float = 0.1) -> dict[str, tuple[float, float]]:
    """A sin(N q + phi) as sine and cosine parts, each within a part of the amplitude."""
    sine, cosine = amplitude * math.cos(phase), amplitude * math.sin(phase)
    size = allowed * abs(amplitude)
    return {"sine": (sine, size), "cosine": (cosine, size), "harmonic": (harmonic, 0.1 * harmonic)}


OVERTONE = {"overtone": 1.0, "overtone_phase": 0.5}  # and its parts
SECOND = {"second_sine": (0.878, 0.1), "second_cosine": (0.479, 0.1)}

CASES = {
    # the plant gives forward minus backward, the library half of it
    "asymmetric_friction": Case("A", {"C0": 2.0, "C2": 0.4}, {"coulomb": (1.0, 0.06), "viscous": (0.2, 0.03)}, 0.3),
    "negative_damping/exponential": Case("B", {"amount": 1.2, "velocity": 0.1}, {"amount": (1.4, 0.4)}, 0.6),
    "negative_damping/gaussian": Case(
        "B", {"amount": 1.2, "velocity": 0.1, "squared": 1.0}, {"amount": (1.2, 0.1), "velocity": (0.1, 0.02)}, 0.3
    ),
    # after a reversal one bristle is twice as stiff as at rest, elements are not
    "presliding/lugre": Case("A", {"stiffness": 300.0, "damping": 4.0}, {"stiffness": (200.0, 100.0)}, 0.25),
    "presliding/maxwell_slip": Case("A", {"stiffness": 300.0, "damping": 4.0}, {"stiffness": (300.0, 60.0)}, 0.15),
    # the plant's elements give way from the first moment on; this bristle is a spring for long, and softer instead
    "presliding/elasto_plastic": Case("A", {"stiffness": 300.0, "damping": 4.0}, {"stiffness": (200.0, 100.0)}, 0.3),
    # the plant delays the viscous part as well, which one pole leaves in phase
    "frictional_lag/one_pole": Case("A", {"time": 0.05}, {"time": (0.04, 0.012)}, 0.92, 2),
    # a delay of 0.05 s in the plant; one pole of the whole curve is as late at slow changes
    "frictional_lag/whole_curve": Case("A", {"time": 0.05}, {"time": (0.06, 0.02)}, 0.7, 2),
    # a chain of three poles leaves 0.33 and 0.58
    "frictional_lag/delay": Case("A", {"time": 0.05}, {"time": (0.05, 0.003)}, 0.26, 2),
    "frictional_lag/falling_part": Case("A", {"time": 0.05, "drop": 1.0}, {"time": (0.05, 0.005)}, 0.5, 2),
    "dwell_time/break_away": Case("A", {"rise": 4.0, "time": 0.5, "distance": 0.02}, {"rise": (4.0, 1.5)}, 0.7),
    "dwell_time/ageing": Case("A", {"rise": 4.0, "time": 0.5, "distance": 0.02}, {"rise": (4.0, 2.0)}, 0.7),
    # the plant's contact ages in motion as well
    "dwell_time/at_rest": Case("A", {"rise": 4.0, "time": 0.5, "distance": 0.02}, {"rise": (4.0, 2.0)}, 0.7),
    # in the plant at once, in the library within 10 ms
    "dwell_time/frozen": Case("A", {"rise": 4.0, "time": 0.3, "distance": 0.0}, {"rise": (4.0, 0.8)}, 0.7),
    # warmed by power in the plant, by speed in the library
    "history/warm_up": Case("A", {"change": -0.5, "time": 8.0, "power": 3.0}, {}, 0.3),
    "history/heat": Case(
        "A", {"change": -0.5, "time": 8.0, "power": 3.0}, {"change": (-0.5 / 3.0, 0.01), "time": (8.0, 0.8)}, 0.1, 3
    ),
    # settled friction is 0.75 of the fresh one, which the nominal file has within 10 %: the prior keeps some of it
    "history/in_time": Case(
        "A",
        {"change": -0.25, "time": 4.0, "power": 0.0},
        {"change": (0.25 / 0.75, 0.05), "time": (4.0, 0.2), "kept": (0.0, 0.1)},
        0.2,
        5,
    ),
    # worn by work in the plant, by distance in the library
    "history/running_in": Case(
        "A", {"change": 0.5, "work": 20.0}, {"change": (0.5, 0.1), "distance": (2.5, 0.5), "kept": (1.0, 0.15)}, 0.3, 2
    ),
    # settled again when the next recording starts, and not before
    "history/thixotropy": Case("A", {"change": 0.5, "work": 20.0, "lost": 1.0}, {"distance": (2.5, 0.5)}, 0.3, 2),
    "load_dependent_friction/proportional": Case("A", {"ratio": 0.2}, {"ratio": (0.2, 0.015)}, 0.3),
    "load_dependent_friction/directional": Case("A", {"ratio": 0.3, "input": 1.0}, {"ratio": (0.3, 0.006)}, 0.1),
    "load_dependent_friction/motor": Case("A", {"ratio": 0.3, "input": 2.0}, {"ratio": (0.3, 0.006)}, 0.1),
    "load_dependent_friction/net": Case("A", {"ratio": 0.3, "input": 4.0}, {"ratio": (0.3, 0.006)}, 0.1),
    "load_dependent_friction/weight": Case("A", {"ratio": 0.3, "input": 3.0}, {"ratio": (0.3, 0.015)}, 0.15),
    # N m in the plant, relative to the sliding level (here C0) in the library
    "position_dependent_friction/one_wave": Case(
        "A", {"amplitude": 2.0, "harmonic": 3.0, "phase": 0.7}, wave(2.0 / 4.6, 0.7, 3.0), 0.3
    ),
    "position_dependent_friction/harmonics": Case(
        "A",
        {"amplitude": 2.0, "harmonic": 3.0, "phase": 0.7} | OVERTONE,
        wave(2.0 / 4.6, 0.7, 3.0) | {"second_sine": (0.878 / 4.6, 0.03), "second_cosine": (0.479 / 4.6, 0.03)},
        0.1,
        3,
    ),
    "quadratic_damping": Case("B", {"coefficient": 0.4}, {"coefficient": (0.4, 0.02)}, 0.3),
    "actuator_lag/one_pole": Case("B", {"time": 0.02}, {"time_constant": (0.02, 0.001)}, 0.3),
    "actuator_lag/two_poles": Case("B", {"time": 0.012, "again": 0.012}, {"time_constant": (0.024, 0.0012)}, 0.3),
    "actuator_lag/magnitude_optimum": Case(
        "B", {"time": 0.024, "damping": math.sqrt(0.5)}, {"time_constant": (0.024, 0.0006)}, 0.1
    ),
    "delay": Case("B", {"time": 0.02}, {"time": (0.02, 0.0006)}, 0.3),
    "torque_gain": Case("B", {"gain": 0.8}, {"gain": (0.8, 0.02)}, 0.4),
    "torque_offset": Case("B", {"offset": 1.0}, {"offset": (1.0, 0.05)}, 0.3),
    "torque_saturation/constant": Case("B", {"limit": 4.5}, {"limit": (4.5, 0.1)}, 0.1),
    "torque_saturation/back_emf": Case(
        "B", {"limit": 6.0, "fade": 0.15}, {"limit": (6.0, 0.2), "fade": (0.15, 0.015)}, 0.1
    ),
    # rounded off by another law: u / (1 + (u / limit)^2.4)^(1 / 2.4) is nearest
    "torque_saturation/smooth": Case("B", {"limit": 9.0, "sharp": 2.4}, {"limit": (9.0, 0.6)}, 0.15),
    "torque_dead_zone/shifted": Case("B", {"width": 1.0}, {"width": (1.0, 0.1)}, 0.4),
    # the plant's torque comes back at once
    "torque_dead_zone/threshold": Case("B", {"width": 2.0, "jump": 1.0}, {"width": (2.0, 0.1)}, 0.5),
    "cogging/one_wave": Case("A", {"amplitude": 1.5, "harmonic": 12.0, "phase": 0.4}, wave(1.5, 0.4, 12.0), 0.4),
    "cogging/two_waves": Case(
        "A", {"amplitude": 1.5, "harmonic": 12.0, "phase": 0.4} | OVERTONE, wave(1.5, 0.4, 12.0) | SECOND, 0.4
    ),
    "torque_ripple/one_wave": Case("A", {"ratio": 0.15, "harmonic": 6.0, "phase": 0.4}, wave(0.15, 0.4, 6.0), 0.3),
    "torque_ripple/two_waves": Case(
        "A",
        {"ratio": 0.15, "harmonic": 6.0, "phase": 0.4, "overtone": 0.1, "overtone_phase": 0.5},
        wave(0.15, 0.4, 6.0) | {"second_sine": (0.0878, 0.01), "second_cosine": (0.0479, 0.01)},
        0.3,
    ),
    "joint_flexibility": Case(
        "B", {"stiffness": 150.0, "damping": 1.0}, {"stiffness": (150.0, 2.0), "damping": (1.0, 0.05)}, 0.1, 2
    ),
    "backlash": Case("B", {"gap": 0.06, "stiffness": 1500.0, "damping": 6.0}, {"gap": (0.06, 0.002)}, 0.1),
    "encoder_eccentricity/one_wave": Case("B", {"amplitude": 0.08, "phase": 0.7}, wave(0.08, 0.7, 1.0, 0.2), 0.65, 2),
    "encoder_eccentricity/two_waves": Case(
        "B",
        {"amplitude": 0.006, "phase": 0.7, "harmonic": 12.0, "overtone": 0.002, "overtone_phase": 0.4},
        wave(0.006, 0.7, 12.0, 0.2) | {"second_sine": (0.00184, 0.0004), "second_cosine": (0.00078, 0.0004)},
        0.3,
        2,
    ),
    "encoder_offset": Case("B", {"offset": 0.05}, {"offset": (0.05, 0.01)}, 0.8),
    "time_shift/one_joint": Case("B", {"time": 0.01}, {"time": (0.01, 0.001)}, 0.5),
    "time_shift/all_joints": Case("A", {"time": -0.01}, {"time": (-0.01, 0.0005)}, 0.2, elsewhere="B"),
    "payload": Case("B", {"mass": 0.6}, {"mass": (0.6, 0.05)}, 0.2),
    "base_flexibility/sliding": Case(
        "A",
        {"stiffness": 8000.0, "damping": 20.0, "mass": 6.0, "direction": 1.2},
        {"stiffness": (8000.0, 400.0), "damping": (20.0, 8.0), "mass": (6.0, 1.0), "direction": (1.2, 0.1)},
        0.3,
    ),
    "base_flexibility/rocking": Case(
        "A",
        {"stiffness": 800.0, "damping": 4.0, "inertia": 0.4},
        {"stiffness": (800.0, 40.0), "damping": (4.0, 1.0), "inertia": (0.4, 0.1)},
        0.3,
    ),
    "gravity_tilt": Case("A", {"x": -0.3, "y": 2.0}, {"x": (-0.3, 0.15), "y": (2.0, 0.1)}, 0.2),
    "cable_spring/linear": Case(
        "B", {"stiffness": 2.0, "rest": 0.4}, {"stiffness": (2.0, 0.1), "rest": (0.4, 0.03)}, 0.2
    ),
    "cable_spring/hardening": Case(
        "B",
        {"stiffness": 1.0, "rest": 0.2, "cubic": 3.0},
        {"stiffness": (1.0, 0.15), "rest": (0.2, 0.03), "cubic": (3.0, 0.3)},
        0.2,
    ),
    "contact/linear": Case(
        "B",
        {"stiffness": 20.0, "position": -0.4, "side": -1.0, "damping": 0.0, "exponent": 1.0, "damper": 0.5},
        {"stiffness": (-20.0, 1.0), "position": (-0.4, 0.02), "damping": (0.5, 0.05)},
        0.1,
    ),
    "contact/hunt_crossley": Case(
        "B",
        {"stiffness": 60.0, "position": 0.4, "side": 1.0, "damping": 0.4},
        {"stiffness": (60.0, 3.0), "position": (0.4, 0.02), "damping": (0.4, 0.1)},
        0.1,
    ),
    "contact/plane": Case(
        "A",
        {"stiffness": 900.0, "direction": 1.2, "position": 0.55, "damping": 0.4},
        {"stiffness": (900.0, 60.0), "direction": (1.2, 0.05), "distance": (0.55, 0.01)},
        0.25,
    ),
    "contact/plane_linear": Case(
        "A",
        {"stiffness": 600.0, "direction": -0.8, "position": 0.5, "damping": 0.4, "exponent": 1.0},
        {"stiffness": (600.0, 30.0), "direction": (-0.8, 0.05), "distance": (0.5, 0.01)},
        0.25,
    ),
    "input_disturbance/harmonics": Case(
        "B",
        {"noise": 0.0, "amplitude": 3.0, "frequency": 1.5, "duty": 0.25},
        # of the Fourier series a_i = 2 A sin(pi i d) / (pi i), in the middle of the pulse
        {"frequency": (1.5, 0.01), "second_sine": (0.955, 0.1), "second_cosine": (0.0, 0.1)},
        0.5,
    ),
    "input_disturbance/one_wave": Case(
        "B",
        {"noise": 0.0, "amplitude": 1.0, "frequency": 3.0, "phase": 0.5},
        {"sine": (math.cos(0.5), 0.05), "cosine": (math.sin(0.5), 0.05), "frequency": (3.0, 0.01)},
        0.3,
    ),
}


SAMPLE = (  # one of each stage; all of them take a good part of a minute
    "load_dependent_friction/proportional", "delay", "joint_flexibility", "time_shift/all_joints", "payload",
    "cable_spring/linear", "frictional_lag/falling_part",
)  # fmt: skip


def fitted(label: str, case: Case, turns: int = 0, factor: float = 1.0) -> tuple[Prepared, Model, Model]:
    """The re-tuned model and the one with the effect, as the search finds it: screened, then fitted.

    All encoders count from ``turns`` away; all masses, inertias and torques are by a ``factor``.
    """
    name, _, law = label.partition("/")
    effect = effect_named(name, law or None)
    bend = name != "negative_damping"
    runs = recorded(name, (case.joint, *case.elsewhere), case.hidden, bend=bend)
    runs = [replace(run, q=run.q + 2.0 * np.pi * turns, tau=factor * run.tau) for run in runs]
    prepared, floor = prepare(scaled(nominal_arm(bend), factor), runs, runs[1:]), factor * FLOOR
    base = retune(prepared, floor, rounds=1)
    weights = weights_of(base, prepared, floor)
    trial = screen(prepared, base, weights, effect, prepared.arm.names.index(case.joint))
    model = fit_model(prepared, [Placed(effect, trial.joint)], weights, base.fit, trial.start, evaluations=25)
    return prepared, base, retune(prepared, floor, model.placed, rounds=case.rounds)


@pytest.mark.parametrize(
    ("label", "case"),
    [pytest.param(n, c, id=n, marks=[] if n in SAMPLE else pytest.mark.slow) for n, c in CASES.items()],
)
def test_recovery(label: str, case: Case) -> None:
    prepared, base, model = fitted(label, case)
    joint = prepared.arm.names.index(case.joint)
    before, after = (np.sqrt(np.mean(one.fit.residual[:, joint] ** 2)) for one in (base, model))
    found = model.placed[0].values
    assert after < case.left * before, (after / before, found)
    for parameter, (value, allowed) in case.expected.items():
        assert found[parameter] == pytest.approx(value, abs=allowed), (parameter, found)


@pytest.mark.parametrize(
    ("label", "place"),
    [
        ("cable_spring/linear", "rest"),
        *(
            pytest.param(*one, marks=pytest.mark.slow)
            for one in [
                ("cable_spring/hardening", "rest"),
                ("contact/linear", "position"),
                ("contact/hunt_crossley", "position"),
            ]
        ),
    ],
)
def test_an_encoder_may_count_from_many_turns_away(label: str, place: str) -> None:
    turns, case = 20, CASES[label]
    _, base, model = fitted(label, case, turns)
    before, after = (np.sqrt(np.mean(one.fit.residual[:, 1] ** 2)) for one in (base, model))
    assert after < case.left * before
    for parameter, (value, allowed) in case.expected.items():
        there = value + 2.0 * np.pi * turns * (parameter == place)
        assert model.placed[0].values[parameter] == pytest.approx(there, abs=allowed)


@pytest.mark.long
@pytest.mark.parametrize("label", ["joint_flexibility", "presliding/lugre"])
def test_an_arm_of_some_mN_m_has_no_bounds_of_its_own(label: str) -> None:
    """All torques by 2^-15, which rounds nothing off: the same effect, as much weaker."""
    factor = 2.0**-15
    (_, _, one), (_, _, other) = (fitted(label, CASES[label], factor=part) for part in (1.0, factor))
    for name, value in one.placed[0].values.items():
        assert other.placed[0].values[name] == pytest.approx(factor * value, rel=1e-3)
    left = [np.sqrt(np.mean(model.fit.residual**2, axis=0)) for model in (one, other)]
    assert left[1] == pytest.approx(factor * left[0], rel=1e-3)


@pytest.mark.long
def test_a_slow_stand_is_found() -> None:
    """It swings at half a hertz: slower than all starts that are lightly damped lead to."""
    hidden = {"stiffness": 120.0, "damping": 4.0, "mass": 6.0, "direction": 1.2}
    _, base, model = fitted("base_flexibility/sliding", Case("A", hidden, {}, 0.3))
    assert np.std(model.fit.residual[:, 0]) < 0.3 * np.std(base.fit.residual[:, 0])
    assert model.placed[0].values["stiffness"] == pytest.approx(120.0, rel=0.1)


def test_a_stand_that_tilts_about_its_foot_is_found() -> None:
    """A pedestal of 0.4 m under the first axis, which both moves and turns that."""
    hidden = {"stiffness": 1500.0, "damping": 4.0, "inertia": 1.2, "foot_x": 0.0, "foot_y": -0.4}
    _, base, model = fitted("base_flexibility/sliding", Case("A", hidden, {}, 0.3))
    assert np.std(model.fit.residual[:, 0]) < 0.3 * np.std(base.fit.residual[:, 0])
    found = model.placed[0].values
    side = np.cos(found["direction"])  # it tilts to and fro along x: forward is as good as backward
    assert abs(side) > 0.98
    assert side * found["turn"] == pytest.approx(-1.0 / 0.4, rel=0.15)
    assert found["stiffness"] == pytest.approx(1500.0 / 0.4**2, rel=0.1)
    assert found["mass"] == pytest.approx(1.2 / 0.4**2, rel=0.3)


def beside_a_play() -> tuple[Prepared, Model, dict[str, float]]:
    """A recording with play at joint B, the re-tuned model, and the play."""
    case = CASES["backlash"]
    runs = recorded("backlash", (case.joint,), case.hidden)
    prepared = prepare(nominal_arm(), runs, runs[1:])
    return prepared, retune(prepared, FLOOR, rounds=1), {"gap": 0.06, "stiffness": 1000.0, "damping": 6.0}


@pytest.mark.slow
def test_a_play_is_found_from_far() -> None:
    """From three of five starts at least; derivatives of a moment, by blows about to fall, end at nine times it."""
    prepared, base, play = beside_a_play()
    weights = weights_of(base, prepared, FLOOR)
    near, *far = (
        fit_model(prepared, [Placed(effect_named("backlash"), 1)], weights, base.fit, play | {"gap": start})
        for start in (0.06, 0.1, 0.11, 0.12, 0.13, 0.14)
    )
    for model in far:
        assert model.placed[0].values["gap"] == pytest.approx(0.06, abs=0.002)
    costs = [model.fit.cost / near.fit.cost for model in far]
    assert sum(cost < 1.3 for cost in costs) >= 3
    assert max(costs) < 5.0


@pytest.mark.parametrize(
    ("name", "key", "start"),
    [
        ("cogging", "harmonic", {"sine": 0.3, "cosine": 0.2, "harmonic": 12.0}),
        ("input_disturbance", "frequency", {"sine": 0.3, "cosine": 0.2, "frequency": 3.0}),
    ],
)
def test_waves_beside_a_play_keep_their_pitch(name: str, key: str, start: dict[str, float]) -> None:
    """A secant over many turns of a wave would know nothing of it."""
    prepared, _, play = beside_a_play()
    placed = [Placed(effect_named("backlash"), 1, play), Placed(effect_named(name), 0, start)]
    path = SignalPath(prepared.arm, placed)
    p = start_values(path, None, start)
    columns = [i for i, entry in enumerate(path.entries) if entry.owner == 1]
    secant, exact = (
        residual(p)[1][:, 0]
        for residual in (differentiable(path, prepared, prepared.fit, columns), Residual(path, prepared.fit, columns))
    )
    own = [path.entries[i].name for i in columns].index(key)
    assert np.corrcoef(secant[:, own], exact[:, own])[0, 1] > 0.98


@pytest.mark.slow
def test_recovery_of_an_encoder_before_a_gear() -> None:
    """It turns fifteen times as fast as the joint."""
    case = Case("B", {"amplitude": 0.006, "phase": 0.7, "harmonic": 15.0}, wave(0.006, 0.7, 15.0, 0.2), 0.3, 2)
    test_recovery("encoder_eccentricity", case)


def test_every_effect_has_a_case_and_every_stage_one_in_the_sample() -> None:
    """What the records show by themselves is tried in `test_observed`."""
    effects = {effect.label: effect for effect in laws().values() if not effect.direct}
    own = {label for label, effect in effects.items() if type(effect).__module__.startswith("stribeck.effects.")}
    assert own == set(CASES)
    assert {effects[label].channel for label in SAMPLE} == {effect.channel for effect in effects.values()}
