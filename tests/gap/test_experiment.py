"""The next experiment: what it promises, that it holds on the independent plant, and that it can be done."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.diagnose import diagnose
from stribeck.gap.experiment import DURATION, Experiment, _Plan, next_experiment, open_question, resolved
from stribeck.gap.files import write_diagnosis
from stribeck.gap.motions import KINDS, Motion, Reach, family
from stribeck.gap.search import Step
from stribeck.gap.separation import AS_IT_IS, Prospect, _excess
from stribeck.report.tables import next_experiment as next_section
from stribeck.run import Run, load_run, save_run
from stribeck.simulate import simulate
from stribeck.simulate.loopfile import load_loop
from stribeck.withheld.injections import Injection

from .conftest import NOMINAL, recorded
from .next_case import CASES, Question, at_random, followed, question

LAG = ("actuator_lag", {"time": 0.005})
OFFSET = ("torque_offset", {"offset": 0.6})


@cache
def late() -> Question:
    return question(recorded(LAG), ("delay", "actuator_lag"))


@cache
def next_of_late() -> Experiment:
    found = next_experiment(late().prepared, late().models, late().floor)
    assert found is not None
    return found


@cache
def biased() -> Question:
    return question(recorded(OFFSET), ("torque_offset", "asymmetric_friction"))


def plan(q: Question) -> _Plan:
    return _Plan(q.prepared, q.models, q.floor)


@cache
def tried_of_late() -> list[tuple[Motion, Prospect]]:
    return plan(late()).tried(family(NOMINAL, [0]))


def test_excess_is_least_squares_with_what_is_known() -> None:
    """The misfit after everything is re-tuned, against numpy's least squares on the stacked system."""
    rng = np.random.default_rng(1)
    left, columns, root = rng.standard_normal(40), rng.standard_normal((40, 3)), rng.standard_normal((3, 3))
    stacked = np.vstack([columns, root])
    _, squares, _, _ = np.linalg.lstsq(stacked, -np.concatenate([left, np.zeros(3)]), rcond=None)
    assert _excess(left, columns, root.T @ root) == pytest.approx(np.sqrt(squares[0]), rel=1e-6)
    within = columns @ np.array([1.0, -2.0, 0.5])
    assert _excess(within, columns, 1e-9 * np.eye(3)) == pytest.approx(0.0, abs=1e-3)


def test_commands_make_the_motion() -> None:
    """Driven by its own commands a model has next to no residual, whatever its drive does to them."""
    q = late()
    p = plan(q)
    runs = [p.planned(Motion("a chirp", (0,)), 4.0)]
    for candidate in p.candidates:
        driven, bare = candidate.misfit(candidate.driven(runs))[0][0], candidate.misfit(runs)[0][0]
        assert np.sqrt(np.mean(driven**2)) < 0.03 * np.sqrt(np.mean(bare**2))  # of a chirp up to the cutoff


def test_lag_or_delay_asks_for_a_motion() -> None:
    found = next_of_late()
    assert found.kind == "motion"
    assert set(found.separates) == {"delay", "actuator_lag"}
    assert found.resolved > 0.9
    assert found.apart >= found.rivals["d_optimal"]
    assert found.apart > 1.3 * found.rivals["random"]
    assert found.apart > 2.0 * late().apart()  # than the recordings so far


def test_the_arm_can_do_it() -> None:
    """Within the recorded range and speed and the stated torque, from rest to rest, at most 20 s."""
    reference, runs = next_of_late().reference, recorded(LAG)
    assert reference.duration <= DURATION + 1e-9 <= 20.0 + 1e-9
    assert reference.q_ref is not None
    assert reference.dq_ref is not None
    q = np.concatenate([run.q for run in runs])
    assert reference.q_ref.min() >= q.min()
    assert reference.q_ref.max() <= q.max()
    fastest = max(np.abs(np.diff(run.q, axis=0)).max() / run.sample_time for run in runs)
    assert np.abs(reference.dq_ref).max() <= fastest
    limit = NOMINAL.joints[0].torque_limit
    assert limit is not None
    assert np.abs(reference.tau).max() <= limit
    for end in (0, -1):
        assert abs(reference.dq_ref[end, 0]) < 0.02 * fastest


@pytest.mark.parametrize("kind", KINDS)
def test_every_motion_stays_within_reach(kind: str) -> None:
    reach = Reach(-0.4, 1.2, 2.5, 20.0, 1e-4, 8.0)
    t = np.arange(0.0, 12.0, 0.004)
    (course,) = Motion(kind, (0,)).course(t, [reach]).T
    speed = np.gradient(course, t)
    assert course.min() >= reach.low - 1e-9
    assert course.max() <= reach.high + 1e-9
    assert np.abs(speed).max() <= reach.speed * 1.01
    assert np.ptp(course) > 0.01 * reach.travel
    assert abs(speed[0]) < 1e-2 * reach.speed
    held = Motion(kind, (1,)).course(t, [reach, reach])
    assert np.ptp(held[:, 0]) == 0.0
    assert np.ptp(held[:, 1]) == pytest.approx(np.ptp(course))
    half = Motion(kind, (0,), 0.5).course(t, [reach])
    assert np.ptp(half) == pytest.approx(0.5 * np.ptp(course))


def test_no_motion_tells_an_offset_from_asymmetry() -> None:
    """Along any motion the two laws are the same: so it says, and asks for a change of the drive."""
    q = biased()
    p = plan(q)
    tried = p.tried(family(NOMINAL, [0]))
    assert max(prospect.least for _, prospect in tried) < 1.0
    found = p.chosen(tried)
    assert found.kind == "change"
    assert "polarity" in found.what
    assert found.apart > 5.0
    assert resolved(found.rivals["d_optimal"]) < 0.2


def test_reversed_drive_shows_which_it_was() -> None:
    """With its drive reversed the plant's offset turns sign in the joint; the friction of the joint would not."""
    reversed_ = [Injection("torque_offset", "A", {"offset": -0.6})]
    runs = [followed(plan(biased()).reference(plan(biased()).planned(Motion(kind, (0,)), 6.0)), reversed_)
            for kind in ("slow ramp reversals", "a multisine", "quick reversals")]  # fmt: skip
    after = question(runs, ("torque_offset", "asymmetric_friction"))
    before = {m.placed[-1].effect.name: m.placed[-1].values for m in biased().models}
    then = {m.placed[-1].effect.name: m.placed[-1].values for m in after.models}
    # the joint's sense: an offset of the reversed drive is minus what the file's sense has, so that it kept its value
    assert -then["torque_offset"]["offset"] == pytest.approx(before["torque_offset"]["offset"], rel=0.1)
    assert then["asymmetric_friction"]["coulomb"] * before["asymmetric_friction"]["coulomb"] < 0.0


def test_reference_is_followed_through_a_loop_file(tmp_path) -> None:  # type: ignore[no-untyped-def]
    reference = next_of_late().reference
    save_run(reference, tmp_path / "next_reference.csv")
    (tmp_path / "loop.toml").write_text(
        'schema = "stribeck.loop/1"\nsample_time = 0.004\nduration = 3.0\n[[joints]]\njoint = "A"\nkp = 3000.0\n'
        'kv = "critical"\n[joints.reference]\nkind = "file"\nfile = "next_reference.csv"\n'
    )
    done = simulate(NOMINAL, load_loop(tmp_path / "loop.toml", NOMINAL))
    assert done.motion.ok
    assert reference.q_ref is not None
    assert done.reference[:, 0] == pytest.approx(reference.q_ref[: len(done.reference), 0], abs=1e-6)
    assert np.abs(done.error).max() < 0.3


def test_promise_is_kept_on_the_plant() -> None:
    """The plant records what is proposed: the two come apart as promised, further than by a random motion."""
    hidden = [Injection(LAG[0], "A", LAG[1])]
    runs, names = recorded(LAG), ("delay", "actuator_lag")
    after = question([*runs, followed(next_of_late().reference, hidden)], names)
    rival = question([*runs, at_random(hidden, 5)], names)
    assert after.best() == "actuator_lag"
    assert after.told_apart()
    assert after.apart() > rival.apart()
    assert 0.4 * next_of_late().apart < after.apart() < 2.5 * next_of_late().apart


@pytest.mark.slow
def test_most_ambiguous_cases_are_resolved_in_one_go() -> None:
    told: dict[str, list[bool]] = {"proposed": [], "random": []}
    for number, (effect, values, names) in enumerate(CASES):
        hidden = [Injection(effect, "A", values)]
        runs = recorded((effect, values))
        q = question(runs, names)
        found = next_experiment(q.prepared, q.models, q.floor)
        assert found is not None
        new: dict[str, Run] = {"proposed": followed(found.reference, hidden), "random": at_random(hidden, 5 + number)}
        for kind, run in new.items():
            after = question([*runs, run], names)
            told[kind].append(after.told_apart() and after.best() == effect)
    assert sum(told["proposed"]) >= 0.75 * len(CASES)
    assert sum(told["proposed"]) >= sum(told["random"])


def test_change_that_changes_nothing() -> None:
    placed = late().models[0].placed
    assert AS_IT_IS.around(placed) == placed


@dataclass(frozen=True)
class Rated:
    """A ranking as far as the question looks at it."""

    overall: np.ndarray
    best: int = 0
    alike: tuple[int, ...] = ()

    def twins(self) -> list[int]:
        return list(self.alike)


def step(overall: list[float], best: int = 0, alike: tuple[int, ...] = ()) -> Step:
    rivals = tuple(replace(late().models[0], held=np.full((1, 1), k)) for k in range(1, len(overall)))
    ranking = Rated(np.array(overall), best, alike)
    return Step(late().base, rivals, ranking, bool(best), (), late().floor)  # type: ignore[arg-type]


def asked(steps: list[Step], *, unexplained: bool) -> list[int]:
    return [int(model.held[0, 0]) for model in open_question(steps, unexplained=unexplained)]


def test_question_is_asked_only_where_there_is_one() -> None:
    alone, alike, lost = step([0, 0.2, 0.5], 2, (2,)), step([0, 0.4, 0.3, 0.6], 3, (1, 2, 3)), step([0, 0.1, -0.2, 0.3])
    assert asked([alone], unexplained=False) == []
    assert asked([alike], unexplained=False) == [3, 1, 2]
    assert asked([alike, alone], unexplained=False) == [3, 1, 2]
    assert asked([lost], unexplained=True) == [3, 1]  # those that gain at all, the best first
    assert asked([step([0, 0.1, -0.2])], unexplained=True) == []


def test_diagnosis_proposes_and_writes_it(tmp_path) -> None:  # type: ignore[no-untyped-def]
    few = [name for name in registry() if name not in set(late().names)]
    found = diagnose(NOMINAL, recorded(LAG), jobs=1, leave_out=few)
    assert len(found.named) == 1
    write_diagnosis(found, tmp_path)
    told = json.loads((tmp_path / "diagnosis.json").read_text())["next_experiment"]
    assert told["kind"] == "motion"
    assert set(told["separates"]) == set(found.causes[0].equivalent) == {"delay", "actuator_lag"}
    assert told["expected_gain"]["probability_resolved"] > 0.9
    written = load_run(tmp_path / told["reference"], 1)
    assert written.q_ref is not None
    assert written.dq_ref is not None
    section = next_section(found)
    assert section is not None
    assert dict(section.pairs)["expected gain"].startswith("The nearest two come out")
