"""A run may be without an effect that the model has: no law of it, no derivative by it, whatever others have."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.placing import entries_of
from stribeck.effects.registry import effect_named
from stribeck.gap.answer.motion import motion_gap
from stribeck.gap.records.prepare import prepare
from stribeck.identify.conditioning import Conditioned, condition, shaken
from stribeck.identify.residual import Residual
from stribeck.identify.secants import Secants
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

from ..gap.conftest import NOMINAL
from ..gap.conftest import recorded as on_the_bench
from .conftest import pendulum, recorded

LIGHT = frozenset({"payload"})
LOAD = Placed(effect_named("payload"), 0, {"mass": 0.4})
OTHERS = {
    "rigid": (),
    "a bristle": (Placed(effect_named("presliding"), 0, {"stiffness": 400.0, "damping": 2.0}),),
    "a shaft": (Placed(effect_named("joint_flexibility"), 0, {"stiffness": 60.0, "damping": 0.8}),),
}


def two(**changes: np.ndarray) -> list[Conditioned]:
    """A run with a load, and one of another motion without."""
    with_it, light = (condition(pendulum(), recorded(duration=2.0, noise=1e-5, seed=seed), 20.0) for seed in (0, 1))
    return [replace(run, **changes) for run in (with_it, replace(light, without=LIGHT))]


def plain(path: SignalPath, runs: Sequence[Conditioned]) -> Residual:
    return Residual(path, runs)


def by_secants(path: SignalPath, runs: Sequence[Conditioned]) -> Residual:
    return Secants(path, runs, np.full(len(path.entries), 0.01), [i for i, e in enumerate(path.entries) if e.sd > 0.0])


@pytest.mark.parametrize("undriven", [False, True])
@pytest.mark.parametrize(
    ("others", "made"),
    [("rigid", plain), ("a bristle", plain), ("a shaft", plain), ("a bristle", by_secants), ("a shaft", by_secants)],
)
def test_each_run_has_its_own(
    others: str, made: Callable[[SignalPath, Sequence[Conditioned]], Residual], undriven: bool
) -> None:
    runs, beside = two(undriven=np.array([undriven])), OTHERS[others]
    path, bare = (SignalPath(pendulum(), placed) for placed in ((*beside, LOAD), beside))
    residual = made(path, runs)
    found, slopes = residual(values_of(path.entries))
    loaded, light = made(path, runs[:1])(values_of(path.entries)), made(bare, runs[1:])(values_of(bare.entries))
    edge, mass = len(loaded[0]), len(residual.columns) - 1
    assert path.entries[residual.columns[mass]].owner == len(beside)
    assert found[:edge] == pytest.approx(loaded[0], abs=1e-9)
    assert slopes[:edge] == pytest.approx(loaded[1], abs=1e-6)
    assert found[edge:] == pytest.approx(light[0], abs=1e-9)
    assert not slopes[edge:, :, mass].any()
    assert np.delete(slopes[edge:], mass, axis=2) == pytest.approx(light[1], abs=1e-6)
    assert np.abs(slopes[:edge, :, mass]).max() > 0.1


def test_its_states_and_stages_are_those_without_it() -> None:
    path, bare = (SignalPath(pendulum(), placed) for placed in ((*OTHERS["a shaft"], LOAD), OTHERS["a shaft"]))
    light = two()[1]
    found, other = (Residual(one, [light], ()) for one in (path, bare))
    p, q = values_of(path.entries), values_of(bare.entries)
    assert found.states(light, p) == pytest.approx(other.states(light, q))
    stages, others = found.stages(light, p), other.stages(light, q)
    assert all(stages[name] == pytest.approx(others[name]) for name in stages)


def test_it_stays_without_it_in_another_conditioning() -> None:
    light = two()[1]
    assert shaken(pendulum(), light, 20.0, np.zeros(light.run.q.shape)).without == LIGHT


def test_a_simulation_is_of_the_arm_without_it() -> None:
    prepared = prepare(NOMINAL, on_the_bench())
    light = [replace(run, without=LIGHT) for run in prepared.held]
    loaded = replace(NOMINAL, effects=entries_of(NOMINAL, [LOAD]))
    asked = (loaded, light), (NOMINAL, prepared.held), (loaded, prepared.held)
    told, bare, wrong = (motion_gap(arm, runs, prepared.cutoff, 0.5)[0]["A"] for arm, runs in asked)
    assert told == pytest.approx(bare, rel=1e-6)
    assert abs(wrong - bare) > 0.05 * bare
