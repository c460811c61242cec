"""A stand that slides, followed along what the simulator moved: alone and under a flexible joint, at slow samples."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint
from stribeck.errors import StribeckError
from stribeck.identify.conditioning import Past, condition
from stribeck.identify.cutoff import cutoff_frequency
from stribeck.identify.noise import encoder_noise
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run
from stribeck.simulate.engine import Engine, path_of

ROUGH = Friction(0.0, 0.0, 0.5, 0.1)
SHAFT = EffectEntry("joint_flexibility", ("A",), {"A": {"stiffness": 900.0, "damping": 2.0}})


def stand(hertz: float, start: float = 0.0, turn: float = 0.0) -> EffectEntry:
    """Of 6 kg under an arm of 6 kg, damped by 3 % of critical; it starts so far from its rest, m."""
    stiffness = 12.0 * (2.0 * np.pi * hertz) ** 2
    values = {"stiffness": stiffness, "damping": 0.06 * np.sqrt(12.0 * stiffness), "mass": 6.0, "direction": 1.2}
    values |= {"start": start, "turn": turn}
    return EffectEntry("base_flexibility", ("A",), {"A": values}, "sliding")


def arm(step: float, *effects: EffectEntry) -> Arm:
    joints = tuple(
        Joint(name, "revolute", length, mass, (0.6 * length, 0.0), 0.05, 0.1, ROUGH, ROUGH)
        for name, length, mass in (("A", 0.5, 4.0), ("B", 0.3, 2.0))
    )
    return Arm("two links", (0.0, 0.0), joints, sample_time=step, effects=effects)


def left(step: float, *effects: EffectEntry, told: EffectEntry | None = None) -> float:
    """What the true values, or others that are ``told``, leave along 12 s of motion without noise, N m rms.

    Of a command of 5.6 N m rms.
    """
    moving = arm(step, *effects)
    engine, t = Engine(path_of(moving)), np.arange(0.0, 12.0, step)
    waves = ((8.0, 0.4, 0.0, 0), (5.0, 1.3, 1.0, 0), (3.0, 3.1, 0.0, 0), (2.0, 5.7, 0.0, 0),
             (4.0, 0.7, 2.0, 1), (2.0, 2.3, 0.0, 1), (1.0, 6.1, 0.0, 1))  # fmt: skip
    command = np.zeros((len(t), 2))
    for size, hertz, phase, joint in waves:
        command[:, joint] += size * np.sin(2.0 * np.pi * hertz * t + phase)
    traced = engine.run(engine.p, engine.start(engine.p, np.array([0.2, 0.4])), t, command)
    run = Run("moved", t, traced.q, command)
    noise = encoder_noise(moving, [run])
    cutoff = cutoff_frequency(moving, [run], engine.moved_inertia(traced.q[0]), noise)
    conditioned = condition(moving, run, cutoff, noise)
    known = engine if told is None else Engine(path_of(arm(step, told)))
    return float(np.sqrt(np.mean(Residual(known.path, [conditioned], ()).value(known.p) ** 2)))


@pytest.mark.parametrize(("hertz", "step", "most"), [(4.0, 0.005, 0.03), (8.0, 0.0125, 0.03), (20.0, 0.005, 0.01)])
def test_a_stand_rings_at_its_own_frequency_at_any_sample_time(hertz: float, step: float, most: float) -> None:
    assert left(step, stand(hertz)) < most


@pytest.mark.parametrize("step", [0.005, 0.0125])
def test_a_stand_under_a_flexible_joint_leaves_little(step: float) -> None:
    """About what the joint leaves alone, 0.06 and 0.02 N m."""
    assert left(step, SHAFT, stand(4.0)) < 0.07


@pytest.mark.parametrize("turn", [-2.0, 2.0])
def test_a_stand_that_tilts_leaves_a_part_for_what_its_tilt_changes(turn: float) -> None:
    """Along a recording it is taken as level; these links fling it about, and a seventh of its effect is left."""
    tilting = stand(4.0, turn=turn)
    assert left(0.005, tilting) < 0.16 * left(0.005, tilting, told=stand(4.0))


def test_a_stand_may_start_off_its_rest() -> None:
    """As where nothing had pressed it down before a recording began; who does not know of it finds it ringing."""
    assert left(0.005, stand(4.0, 0.01), told=stand(4.0)) > 0.8
    assert left(0.005, stand(4.0, 0.01)) < 0.03


@pytest.mark.parametrize(("lead", "off"), [(0.0, 0.01), (3.0, 0.0)])
def test_a_part_of_a_recording_does_not_start_as_the_recording_did(lead: float, off: float) -> None:
    path = path_of(arm(0.01, stand(4.0, 0.01)))
    t = np.arange(0.0, 3.0, 0.01)
    q = np.stack([0.3 * np.sin(3.0 * t), 0.2 * np.sin(5.0 * t)], axis=1)
    run = replace(condition(path.arm, Run("part", t, q, np.zeros_like(q)), 10.0), past=Past(lead=lead))
    states = Residual(path, [run], ()).states(run, values_of(path.entries))
    assert states[0, path.stand_rows[0]] == pytest.approx(off)


def test_two_stands_are_refused() -> None:
    from stribeck.effects.registry import effect_named

    slides = effect_named("base_flexibility", "sliding")
    with pytest.raises(StribeckError, match=r"\(stand\)"):
        SignalPath(arm(0.01), [Placed(slides, 0), Placed(slides, 0)])
