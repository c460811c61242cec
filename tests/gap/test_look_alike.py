"""Laws of no library that pass for an effect are told from it; the effect itself stands against all of them."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.arm import Arm
from stribeck.effects.registry import effect_named, registry
from stribeck.gap.decoys import decoys
from stribeck.gap.diagnose import diagnose
from stribeck.gap.look_alike import TELLING, told_alike
from stribeck.gap.step import LookAlike
from stribeck.gap.verdict import NAMED_OVER, causes_of
from stribeck.model.layout import Placed
from stribeck.model.values import Scale
from stribeck.run import Run
from stribeck.withheld.arms import misinformed
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import Injection
from stribeck.withheld.recorder import default_gains, record

from .conftest import JOINT, conditioned, taken_steps

TRUE = Arm("two joints", (9.81, 0.0), (JOINT, replace(JOINT, name="B", mass=2.5)), sample_time=0.004)
NOMINAL = misinformed(TRUE, np.random.default_rng(3), 0.03, 0.2)
CROSS_TALK = 0.05
OTHERS = tuple(name for name in registry() if name not in ("torque_gain", "payload", "cable_spring"))


def recordings(*hidden: Injection) -> list[Run]:
    kinds = ("slow reversals", "multisine", "via points", "point to point")
    motions = programme(NOMINAL, np.random.default_rng(1), kinds, 6.0)
    gains = default_gains(NOMINAL, 3.0)
    return list(record(TRUE, hidden, motions, rate=250.0, noise=1e-5, gains=gains, model=NOMINAL, seed=5))


def crossed(runs: list[Run]) -> list[Run]:
    """The same motions under drives of which the second also gives a share of the first one's command."""
    mixing = np.array([[1.0, 0.0], [CROSS_TALK, 1.0]])
    return [replace(run, tau=run.tau @ np.linalg.inv(mixing).T) for run in runs]


def test_cross_talk_of_drives_is_no_torque_gain() -> None:
    found = diagnose(NOMINAL, crossed(recordings()), leave_out=OTHERS, jobs=1)
    assert not found.named
    assert found.verdict == "unexplained"
    assert any("a share of A's command at B" in text for text in found.warnings)
    (unknown,) = (cause for cause in found.causes if cause.effect == "unknown")
    assert unknown.probability > 0.5


def test_a_torque_gain_is_no_cross_talk() -> None:
    found = diagnose(NOMINAL, recordings(Injection("torque_gain", "A", {"gain": 0.85})), leave_out=OTHERS, jobs=1)
    assert found.named == ("torque_gain",)
    assert found.causes[0].joints == ("A",)
    assert not any("library" in text for text in found.warnings)


def alike(chance: float | None) -> list[Any]:
    """The step of a search that took a torque gain, with a decoy that does better with some chance."""
    (step,) = taken_steps([Placed(effect_named("torque_gain"), 1)], [9.0], gap=np.ones(2), floor=np.ones(2))
    step.look_alike = None if chance is None else LookAlike("something else", chance)
    return [step]


def test_its_chance_is_taken_from_the_presence() -> None:
    scales = (Scale(1.0, 1.0, 1.0, 1.0, 1.0, 1e-3),) * 2
    sure, doubted, gone = (causes_of(alike(c), ("A", "B"), scales) for c in (None, 0.5, 1.0))
    whole = sure[0][0].presence or 0.0
    assert whole > NAMED_OVER
    assert doubted[0][0].presence == pytest.approx(0.5 * whole)
    assert gone[0][0].presence == 0.0
    assert gone[1] == pytest.approx(1.0)  # for unknown


def test_it_is_told_of() -> None:
    assert told_alike(alike(None), ("A", "B")) == []
    assert told_alike(alike(0.5 * TELLING), ("A", "B")) == []
    (text,) = told_alike(alike(0.9), ("A", "B"))
    assert "torque_gain at B" in text
    assert "something else" in text


def test_every_pair_and_joint_has_its_decoys() -> None:
    one, two, three = (list(decoys(names)) for names in (["A"], ["A", "B"], ["A", "B", "C"]))
    assert 0 < len(one) < len(two) < len(three)
    assert len({decoy.says for decoy in three}) == len(three)


def smooth() -> Any:
    """Two joints on sines, with exact velocities and accelerations, and its sampling step."""
    t = np.linspace(0.0, 6.0, 60001)
    waves = [(0.9, 0.5, 0.2), (0.6, 0.8, 1.1)]
    w = [2.0 * np.pi * f for _, f, _ in waves]
    q, v, a = (
        np.stack(
            [
                size * k**order * np.sin(k * t + phase + 0.5 * np.pi * order)
                for (size, _, phase), k in zip(waves, w, strict=True)
            ],
            1,
        )
        for order in range(3)
    )
    return SimpleNamespace(time=t, position=q, velocity=v, acceleration=a)


ENERGIES: dict[str, Callable[[Any], np.ndarray]] = {
    "an inertia at B that varies 1 time a turn": lambda m: 0.5 * np.cos(m.position[:, 1]) * m.velocity[:, 1] ** 2,
    "an inertia at A that varies 2 times a turn": lambda m: 0.5 * np.cos(2 * m.position[:, 0]) * m.velocity[:, 0] ** 2,
    "an inertia between A and B": lambda m: np.prod(m.velocity, axis=1),
    "a spring between A and B": lambda m: np.prod(m.position - m.position.mean(axis=0), axis=1),
}


@pytest.mark.parametrize("says", ENERGIES)
def test_what_stores_energy_gives_it_back(says: str) -> None:
    """The power of its torques is the rate of an energy: the law of an inertia or a spring, and no other."""
    motion = smooth()
    (decoy,) = (decoy for decoy in decoys(["A", "B"]) if decoy.says.startswith(says))
    power = np.sum(decoy.terms[0](motion) * motion.velocity, axis=1)
    rate = np.gradient(ENERGIES[says](motion), motion.time)
    assert power[5:-5] == pytest.approx(rate[5:-5], abs=2e-3 * np.abs(rate).max())


@pytest.mark.parametrize(
    "says", ["friction between A and B, in their common", "friction between A and B, in their rel"]
)
def test_what_rubs_takes_energy_in_its_own_motion_alone(says: str) -> None:
    motion = smooth()
    (decoy,) = (decoy for decoy in decoys(["A", "B"]) if decoy.says.startswith(says))
    power = np.sum(decoy.terms[0](motion) * motion.velocity, axis=1)
    side = 1.0 if "common" in says else -1.0
    assert power == pytest.approx(np.abs(motion.velocity[:, 0] + side * motion.velocity[:, 1]), abs=1e-12)


def test_rows_are_filtered_as_a_residual_is() -> None:
    runs = conditioned([3.0, 4.0])
    for decoy in decoys(["A"]):
        rows = decoy.rows(runs)
        assert rows.shape == (sum(len(run.analysis_index) for run in runs), 1, len(decoy.terms))
        first = runs[0].filtered(decoy.terms[0](runs[0]))
        assert rows[: len(first), :, 0] == pytest.approx(first)
