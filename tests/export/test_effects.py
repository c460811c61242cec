"""Every effect of the registry exports, and moves as the arm's own simulator."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from stribeck.arm import Arm, EffectEntry
from stribeck.effects.registry import laws, registry
from stribeck.errors import InputError
from stribeck.export import export_fmu
from stribeck.model.effect import Effect
from stribeck.model.scale import Scale
from stribeck.simulate import Engine, path_of

from .conftest import two_links
from .driver import OK, Fmu
from .exchange import exchanged

SCALE = Scale(torque=8.0, friction=4.0, speed=0.7, travel=1.5, inertia=0.5, sample_time=0.01)
TIMES = 0.01 * np.arange(61)
COMMAND = np.stack([12.0 * np.sin(9.0 * TIMES), 6.0 * np.cos(11.0 * TIMES)], axis=1)


def with_effects(*effects: Effect) -> Arm:
    entries = []
    for effect in effects:
        joint = "AB"[effect.sites(2)[-1]]
        entries.append(EffectEntry(effect.name, (joint,), {joint: effect.starts(SCALE)[0]}, effect.law or None))
    return two_links(*entries, gravity=(9.81, 0.0))


def compared(fmu: Fmu, arm: Arm) -> float:
    """Largest departure of position and velocity from the simulator's, both from rest."""
    engine = Engine(path_of(arm))
    start = engine.start(engine.p, np.zeros(2), command=COMMAND[0])
    own = engine.run(engine.p, start, TIMES, COMMAND)
    it, rows = fmu.instance().begin({"tau[1]": COMMAND[0, 0], "tau[2]": COMMAND[0, 1]}), []
    for k, t in enumerate(TIMES):
        rows.append(it.get("q[1]", "q[2]", "dq[1]", "dq[2]"))
        it.put({"tau[1]": COMMAND[k, 0], "tau[2]": COMMAND[k, 1]})
        if k + 1 < len(TIMES):
            assert it.step(t, TIMES[k + 1] - t) == OK, it.log
    it.free()
    assert np.abs(own.q).max() > 1e-3
    return float(np.abs(np.array(rows) - np.hstack([own.q, own.dq])).max())


MIXED = ("presliding", "actuator_lag", "joint_flexibility", "cogging", "cable_spring", "encoder_eccentricity", "delay")


@pytest.mark.slow  # the largest model to build
def test_several_effects_at_once(made: Callable[[Arm, int], Path]) -> None:
    """One of each stage, and a delay."""
    arm = with_effects(*[registry()[name] for name in MIXED])
    fmu = Fmu(made(arm, 3))
    assert validate_fmu(str(fmu.path)) == []
    assert compared(fmu, arm) < 1e-9
    assert "effect.presliding[2].stiffness" in fmu.vr


@pytest.mark.slow
@pytest.mark.parametrize("effect", [pytest.param(e, id=e.label) for e in laws().values()])
def test_every_effect(effect: Effect, made: Callable[[Arm, int], Path]) -> None:
    arm = with_effects(effect)
    for fmi in (2, 3):
        fmu = Fmu(made(arm, fmi))
        assert validate_fmu(str(fmu.path)) == []
        assert compared(fmu, arm) < 1e-9
        if effect.delays:
            assert fmu.instance("me").c is None
            continue
        engine = Engine(path_of(arm))
        own = engine.run(engine.p, engine.start(engine.p, np.zeros(2), command=COMMAND[0]), TIMES, COMMAND)
        me = fmu.instance("me").begin({"tau[1]": COMMAND[0, 0], "tau[2]": COMMAND[0, 1]})
        found, _ = exchanged(me, TIMES[:21], COMMAND, rtol=1e-8)
        me.free()
        assert np.abs(found[:, :2] - own.q[:21]).max() < 1e-6


def test_a_record_ahead_of_its_torque_is_refused(tmp_path: Path) -> None:
    arm = two_links(EffectEntry("time_shift", ("A",), {"A": {"time": -0.01}}))
    with pytest.raises(InputError, match="looks ahead in time"):
        export_fmu(arm, tmp_path / "a.fmu")
    assert list(tmp_path.iterdir()) == []
