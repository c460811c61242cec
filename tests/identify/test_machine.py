"""Machines are shared by the paths whose equations are the same, and by no others."""

import pickle
from collections import OrderedDict
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm
from stribeck.effects.registry import effect_named, laws
from stribeck.identify import machine as module
from stribeck.identify.conditioning import condition
from stribeck.identify.machine import machine_of
from stribeck.identify.residual import Residual
from stribeck.identify.tape import Tape
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

from .conftest import pendulum, recorded

BRISTLE = {"stiffness": 400.0, "damping": 2.0}


@pytest.fixture(autouse=True)
def _none_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_kept", OrderedDict())


def path(law: str = "lugre", values: dict[str, float] = BRISTLE, arm: Arm | None = None) -> SignalPath:
    return SignalPath(arm or pendulum(), [Placed(effect_named("presliding", law), 0, values)])


def changed(**what: float) -> Arm:
    (joint,) = pendulum().joints
    return replace(pendulum(), joints=(replace(joint, **what),))


def test_other_values_have_the_same_equations() -> None:
    first = machine_of(path(), 0.002, (0, 9), observe=True)
    heavier = path(values={"stiffness": 900.0, "damping": 0.1}, arm=changed(mass=9.0))
    assert machine_of(heavier, 0.002, (0, 9), observe=True) is first
    far = Placed(pickle.loads(pickle.dumps(effect_named("presliding", "lugre"))), 0, BRISTLE)
    assert machine_of(SignalPath(pendulum(), [far]), 0.002, (0, 9), observe=True) is first


def test_what_is_written_into_the_equations_tells_them_apart() -> None:
    constants = pendulum().joints[0].friction
    others = [
        machine_of(path("maxwell_slip"), 0.002, (0, 9), observe=True),
        machine_of(path(arm=changed(length=0.77)), 0.002, (0, 9), observe=True),
        machine_of(path(arm=replace(pendulum(), gravity=(0.0, 0.0))), 0.002, (0, 9), observe=True),
        machine_of(path(arm=changed(backward=replace(constants, C0=1.0))), 0.002, (0, 9), observe=True),
        machine_of(path(), 0.004, (0, 9), observe=True),
        machine_of(path(), 0.002, (0, 8), observe=True),
        machine_of(path(), 0.002, (0, 9), observe=False),
        machine_of(path(), 0.002, (0, 9), observe=True),
    ]
    assert len({id(machine) for machine in others}) == len(others)


def test_laws_are_equal_to_themselves_alone() -> None:
    known = list(laws().values())
    assert len(set(known)) == len(known)
    assert [known.index(type(law)()) for law in known] == list(range(len(known)))


def test_a_shared_machine_gives_what_one_of_its_own_gives() -> None:
    run = condition(pendulum(), recorded(duration=2.0, noise=1e-5), 20.0)
    stiff = path(values={"stiffness": 900.0, "damping": 0.1}, arm=changed(mass=9.0))
    alone = Residual(stiff, [run])(values_of(stiff.entries))
    module._kept.clear()
    Residual(path(), [run])(values_of(path().entries))
    shared = Residual(stiff, [run])(values_of(stiff.entries))
    assert len(module._kept) == 1
    assert all((mine == its).all() for mine, its in zip(alone, shared, strict=True))
    assert np.ptp(shared[0]) > 0.0


def test_the_last_ones_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "KEPT", 2)
    first, _, again = (machine_of(path(), 0.002, (i,), observe=True) for i in (0, 1, 0))
    assert again is first
    machine_of(path(), 0.002, (2,), observe=True)
    assert len(module._kept) == 2
    assert machine_of(path(), 0.002, (0,), observe=True) is first
    assert machine_of(path(), 0.002, (1,), observe=True) is not first


def test_what_moves_nothing_is_not_worked_out_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Once along each run, until another value or delay asks for it; the residual is the same to the last bit."""
    runs = [condition(pendulum(), recorded(duration=2.0, noise=1e-5, seed=seed), 20.0) for seed in (0, 1)]
    late = SignalPath(pendulum(), [Placed(effect_named("delay"), 0, {"time": 0.01}), *path().placed])
    own = [i for i, entry in enumerate(late.entries) if entry.name in ("C1", "stiffness")]
    mass, delay = (next(i for i, entry in enumerate(late.entries) if entry.name == name) for name in ("mass", "time"))
    made: list[int] = []
    keep = Tape.keep

    def counted(tape: Tape, inputs: list[np.ndarray]) -> np.ndarray:
        made.append(1)
        return keep(tape, inputs)

    monkeypatch.setattr(Tape, "keep", counted)
    residual, p = Residual(late, runs, own), values_of(late.entries)
    for i, anew in ((own[0], 2), (own[1], 0), (own[0], 0), (mass, 2), (own[1], 0), (delay, 2)):
        p[i] *= 1.1
        made.clear()
        found = residual(p)
        assert len(made) == anew
        expected = Residual(late, runs, own)(p)
        assert all((mine == its).all() for mine, its in zip(found, expected, strict=True))


def test_only_so_much_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_KEPT", 0)
    runs = [condition(pendulum(), recorded(duration=2.0, noise=1e-5, seed=seed), 20.0) for seed in (0, 1)]
    residual = Residual(path(), runs)
    kept = residual(values_of(path().entries))
    assert len(residual._kept[frozenset()]._of) == 1
    monkeypatch.setattr(module, "MOST_KEPT", 10**9)
    assert all((a == b).all() for a, b in zip(kept, Residual(path(), runs)(values_of(path().entries)), strict=True))
