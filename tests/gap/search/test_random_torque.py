"""Random torque: what knows nothing of the motion is noise, and nothing that a law leaves passes for it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.answer.files import diagnosis_json
from stribeck.gap.diagnose import diagnose
from stribeck.gap.fitted.model import Model, retune
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.records.spread import Noise
from stribeck.gap.result import Diagnosis
from stribeck.gap.search import judged
from stribeck.gap.search.random_torque import _features, _unforetold, random_joints, random_torque
from stribeck.report import sentences
from stribeck.run import Run

from ..conftest import NOMINAL, conditioned, recorded

FLOOR = np.array([0.02])
NOISE = {"amplitude": 0.0, "frequency": 1.0, "phase": 0.0, "noise": 0.3, "bandwidth": 3.0}
LOUD = {**NOISE, "noise": 0.4}  # over what encoder noise leaves
TOO_LOUD = {**NOISE, "noise": 1.0}  # an eighth of the torque asked for
LEVEL = 0.4  # N m


def retuned(runs: list[Run], floor: np.ndarray = FLOOR) -> tuple[Prepared, Model]:
    prepared = prepare(NOMINAL, runs)
    return prepared, retune(prepared, floor)


def test_coloured_noise_in_the_torque_is_random() -> None:
    prepared, base = retuned(recorded(("input_disturbance", NOISE)))
    (found,) = random_torque(prepared, base, FLOOR)
    assert found.joint == NOMINAL.names[0]
    assert found.unit == "N m"
    assert found.rms == pytest.approx(NOISE["noise"], rel=0.5)  # one short run is held out
    assert 0.5 * NOISE["bandwidth"] < found.bandwidth < 2.0 * NOISE["bandwidth"]


@pytest.fixture(scope="module")
def loud() -> tuple[Diagnosis, set[tuple[int, ...]]]:
    """A diagnosis, and at which joints what is left is random by what the search tells its gates."""
    gate, told = judged.earns_its_place, set()

    def watched(*given: Any) -> bool:
        told.add(tuple(given[5]))
        return gate(*given)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(judged, "earns_its_place", watched)
        return diagnose(NOMINAL, recorded(("input_disturbance", LOUD)), jobs=1), told


@pytest.mark.long
@pytest.mark.long
def test_it_counts_as_noise_and_nothing_is_named(loud: tuple[Diagnosis, set[tuple[int, ...]]]) -> None:
    found, told = loud
    assert told == {(0,)}
    assert found.verdict == "no_gap"
    assert not found.named
    floor = next(stage.torque for stage in found.stages if stage.stage == "noise_floor")[NOMINAL.names[0]]
    assert floor > found.random[0].rms
    chance = {cause.effect: cause.probability for cause in found.causes}
    assert chance["none"] > chance["input_disturbance"] > 0.05
    assert sum(chance.values()) == pytest.approx(1.0)
    others = [name for name in registry() if name not in ("delay", "payload")]
    without = diagnose(NOMINAL, recorded(("input_disturbance", LOUD)), jobs=1, leave_out=others)
    assert "input_disturbance" not in {cause.effect for cause in without.causes}


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("presliding", {"stiffness": 60.0, "damping": 0.5}),
        ("backlash", {"gap": 0.02}),
        ("actuator_lag", {"time": 0.02}),
        ("cable_spring", {"stiffness": 3.0, "rest": 0.5}),
        ("cogging", {"amplitude": 0.5, "harmonic": 7.0, "phase": 0.3}),
    ],
)
def test_a_missing_law_is_not_random(effect: str, values: dict[str, float]) -> None:
    prepared, base = retuned(recorded((effect, values)))
    rms = np.sqrt(np.mean(np.concatenate([base.fit.residual, base.held]) ** 2))
    assert rms > 1.5 * FLOOR[0]
    assert random_torque(prepared, base, FLOOR) == ()


def noise_of(prepared: Prepared, levels: Sequence[float], seed: int = 0) -> np.ndarray:
    """Return steady noise (M, 1), as strong as told in each run."""
    rng = np.random.default_rng(seed)
    rows = [len(run.analysis_index) for run in (*prepared.fit, *prepared.held)]
    made = [np.convolve(rng.normal(size=n + 7), np.hanning(8), "valid") for n in rows]
    whole = np.std(np.concatenate(made))
    return np.concatenate([LEVEL * level * part / whole for level, part in zip(levels, made, strict=True)])[:, None]


def leaving(base: Model, residual: np.ndarray) -> Model:
    fitted = len(base.fit.residual)
    return replace(base, fit=replace(base.fit, residual=residual[:fitted]), held=residual[fitted:])


@pytest.mark.parametrize(("law", "most", "least"), [(0.0, 10, 8), (0.5, 9, 1), (0.9, 0, 0)])
def test_what_other_runs_foretell_is_not(law: float, most: int, least: int) -> None:
    """A linear law leaves a residual as steady and as normal as the motion is; its part is never called random.

    Of ten draws of the noise, mixed evenly with a law's part, some are random; as soon as they are, by that part only.
    """
    prepared, base = retuned(recorded())
    runs = (*prepared.fit, *prepared.held)
    speed = np.concatenate([run.velocity[run.analysis_index] for run in runs])
    told = []
    for seed in range(10):
        noise = noise_of(prepared, [1.0] * len(runs), seed)
        residual = np.sqrt(law) * LEVEL * speed / speed.std() + np.sqrt(1.0 - law) * noise
        told += [row.rms for row in random_torque(prepared, leaving(base, residual), FLOOR)]
    assert least <= len(told) <= most
    assert told == pytest.approx([LEVEL * np.sqrt(1.0 - law)] * len(told), rel=0.3)


def test_friction_that_is_uneven_over_the_travel_is_foretold_by_other_runs() -> None:
    runs = conditioned([20.0] * 4)
    speed, place = (
        np.concatenate([getattr(run, name)[run.analysis_index] for run in runs])[:, 0]
        for name in ("velocity", "position")
    )
    features, noise = _features(runs), np.random.default_rng(0).standard_normal(len(place))
    for lobes in (2.0, 3.0, 5.0):
        assert _unforetold(np.sin(lobes * place) * np.sign(speed), runs, features) < 0.1
    assert _unforetold(noise, runs, features) > 0.9


@pytest.mark.long
def test_what_takes_a_good_part_of_the_torque_is_no_noise_of_a_laboratory() -> None:
    others = [name for name in registry() if name not in ("delay", "payload", "input_disturbance")]
    found = diagnose(NOMINAL, recorded(("input_disturbance", TOO_LOUD)), jobs=1, leave_out=others)
    assert (found.verdict, found.named, found.random) == ("unexplained", (), ())


def test_from_fewer_rows_than_laws_have_terms_nothing_is_told() -> None:
    """Slow noise is not foretold, but four short runs hold less of it than laws have terms (about 50, and 55)."""
    prepared, base = retuned(recorded())
    rows = [len(run.analysis_index) for run in (*prepared.fit, *prepared.held)]
    rng = np.random.default_rng(2)
    slow, fast = (
        np.concatenate([np.convolve(rng.normal(size=n + w - 1), np.hanning(w), "valid") for n in rows])[:, None]
        for w in (13, 9)
    )
    assert random_joints(prepared, leaving(base, LEVEL * fast / fast.std()), FLOOR)
    assert not random_joints(prepared, leaving(base, LEVEL * slow / slow.std()), FLOOR)


def test_noise_of_one_run_is_not_the_arm_s() -> None:
    prepared, base = retuned(recorded())
    assert random_torque(prepared, leaving(base, noise_of(prepared, [1.0, 1.0, 1.0, 0.9])), FLOOR)
    assert random_torque(prepared, leaving(base, noise_of(prepared, [1.0, 1.0, 1.0, 0.3])), FLOOR) == ()


def test_a_joint_that_rests_tells_nothing() -> None:
    prepared, base = retuned(recorded())
    assert random_joints(prepared, leaving(base, 0.0 * np.concatenate([base.fit.residual, base.held])), FLOOR) == {}


def test_at_the_floor_there_is_nothing_to_tell() -> None:
    prepared, base = retuned(recorded(("input_disturbance", LOUD)))
    (found,) = random_torque(prepared, base, FLOOR)
    level = np.sqrt(np.mean(base.held**2, axis=0))
    assert random_torque(prepared, base, level / 1.1) == ()
    assert random_torque(prepared, base, level / 1.3)[0].rms < found.rms
    assert random_joints(prepared, base, level) != {}  # filters over it count for nothing at any size


@pytest.mark.long
def test_loud_random_torque_is_warned_of_and_written(loud: tuple[Diagnosis, set[tuple[int, ...]]]) -> None:
    found, _ = loud
    assert any("random torque" in text for text in found.warnings)
    written = diagnosis_json(found)["random_torque"]["A"]
    assert written["rms"] == {"value": pytest.approx(found.random[0].rms, rel=1e-5), "unit": "N m"}
    assert written["bandwidth"]["unit"] == "Hz"
    assert "random torque" in sentences.how_far(found)
    assert "random_torque" not in diagnosis_json(replace(found, random=()))
    assert "random" not in sentences.how_far(replace(found, random=()))


def test_what_a_models_own_noise_accounts_for_is_steady() -> None:
    """Four times as loud in every other second is not random torque, but for a model that makes such noise of its own.

    Told by rows that are loud elsewhere, it is as little so.
    """
    prepared, base = retuned(recorded())
    runs = (*prepared.fit, *prepared.held)
    even = [np.broadcast_to(FLOOR, residual.shape) for residual in (base.fit.residual, base.held)]
    prepared = replace(prepared, noise=Noise(*even, drawn=np.zeros_like(base.whole)))
    times = np.concatenate([run.told_time[run.analysis_index] for run in runs])
    loud = (times % 2.0 < 1.0)[:, None]
    left = leaving(base, noise_of(prepared, [1.0] * len(runs)) * np.where(loud, 1.0, 0.25))
    own, elsewhere = (np.where(where, 1.0, 0.0625) * LEVEL**2 for where in (loud, ~loud))
    assert not random_joints(prepared, left, FLOOR)
    assert random_joints(prepared, replace(left, rows=own), FLOOR)
    assert not random_joints(prepared, replace(left, rows=elsewhere), FLOOR)
