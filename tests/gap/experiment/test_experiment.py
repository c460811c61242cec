"""The next experiment: what it promises, that it holds on the independent plant, and that it can be done."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.answer.files import write_diagnosis
from stribeck.gap.diagnose import diagnose
from stribeck.gap.experiment import plan as plan_module
from stribeck.gap.experiment.choice import Options, resolved
from stribeck.gap.experiment.motions import KINDS, Motion, Reach, family
from stribeck.gap.experiment.plan import DURATION, PARTS, WIDER, Plan
from stribeck.gap.experiment.programme import PART, Programme, shortest
from stribeck.gap.experiment.proposal import WORTH, Experiment, next_experiment, open_question
from stribeck.gap.experiment.separation import AS_IT_IS, Prospect, _excess
from stribeck.gap.search.step import Step
from stribeck.identify.conditioning import shaken
from stribeck.report.tables import next_experiment as next_section
from stribeck.run import Run, load_run, save_run
from stribeck.simulate import simulate_loop
from stribeck.simulate.loopfile import load_loop
from stribeck.withheld.injections import Injection

from ..conftest import NOMINAL, recorded
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


def plan(q: Question) -> Plan:
    return Plan(q.prepared, q.models, q.floor)


@cache
def options_of_late() -> Options:
    return plan(late()).options()


def test_excess_is_least_squares_with_what_is_known() -> None:
    """The misfit after everything is re-tuned, against numpy's least squares on the stacked system."""
    rng = np.random.default_rng(1)
    left, columns, root = rng.standard_normal(40), rng.standard_normal((40, 3)), rng.standard_normal((3, 3))
    stacked = np.vstack([columns, root])
    _, squares, _, _ = np.linalg.lstsq(stacked, -np.concatenate([left, np.zeros(3)]), rcond=None)
    curved = columns.T @ columns
    found = _excess(float(left @ left), columns.T @ left, root.T @ root + curved)
    assert found == pytest.approx(np.sqrt(squares[0]), rel=1e-6)
    within = columns @ np.array([1.0, -2.0, 0.5])
    assert _excess(float(within @ within), columns.T @ within, curved) == pytest.approx(0.0, abs=1e-3)
    assert _excess(np.nan, columns.T @ left, curved) == 0.0


def test_what_recordings_promise_adds_up() -> None:
    """Two recordings together promise what one with the rows of both does."""
    rng = np.random.default_rng(2)
    known = (np.eye(2), 2.0 * np.eye(2))

    def promise(left: np.ndarray, columns: np.ndarray, torque: float) -> Prospect:
        own = (np.zeros(2), columns.T @ left), (columns.T @ left, np.zeros(2))
        grown = columns.T @ columns
        square = float(left @ left) * (1.0 - np.eye(2))
        return Prospect(square, own, ((grown, grown), (grown, grown)), known, np.array([torque]))

    first, second = (rng.standard_normal(10), rng.standard_normal((10, 2))), (rng.standard_normal(7), np.ones((7, 2)))
    both = promise(*first, 3.0) + promise(*second, 5.0)
    stacked = promise(np.concatenate([first[0], second[0]]), np.vstack([first[1], second[1]]), 5.0)
    assert both.apart == pytest.approx(stacked.apart)
    assert both.apart[0, 1] != pytest.approx(both.apart[1, 0])  # what the two models know differs
    assert both.pairs[0, 1] == both.pairs[1, 0] == min(both.apart[0, 1], both.apart[1, 0])
    assert both.information == pytest.approx(stacked.information)
    assert both.torque == 5.0
    assert both.worth > promise(*first, 3.0).worth


def test_commands_make_the_motion() -> None:
    """Driven by its own commands a model has next to no residual, whatever its drive does to them."""
    q = late()
    p = plan(q)
    t = np.arange(0.0, 4.0, p.step)
    runs = [p.planned("a chirp", Motion("a chirp", (0,)).course(t, p.seen))]
    noise = [np.ones((len(runs[0].analysis_index), 1))]
    for candidate in p.candidates:
        driven, bare = candidate.misfit(candidate.driven(runs), noise)[0][0], candidate.misfit(runs, noise)[0][0]
        assert np.sqrt(np.mean(driven**2)) < 0.03 * np.sqrt(np.mean(bare**2))  # of a chirp up to the cutoff


def test_a_quick_motion_is_told_to_be_noisier_than_a_slow_one() -> None:
    """The recorded ones scatter by what the weights say, as does a slow one; filters leave more of quick reversals."""
    p = plan(late())
    t = np.arange(0.0, 4.0, p.step)
    smooth = [p.planned("a sine", 0.3 * (1.0 - np.cos(rate * t))[:, None]) for rate in (5.0, 25.0)]
    noise = [*p._noise(p.candidates[0].driven(smooth)), *map(p.noise_along, p.prepared.fit)]
    slow, quick, *recorded_ones = (float(np.sqrt(np.mean(sd**2))) for sd in noise)
    so_far = float(np.sqrt(np.mean(p.weights.sd**2)))
    assert recorded_ones == pytest.approx([so_far] * len(recorded_ones), rel=0.3)
    assert slow == pytest.approx(so_far, rel=0.3)
    assert quick > 1.25 * slow


def test_a_planned_motion_is_driven_though_its_commands_are_yet_to_be_found() -> None:
    """Once its noise is drawn, too: at a joint without a drive the equations are told for another inertia."""
    p = plan(late())
    run = p.planned("still to come", 0.3 * (1.0 - np.cos(2.0 * np.arange(0.0, 4.0, p.step)))[:, None])
    noisy = shaken(p.prepared.arm, run, p.prepared.cutoff, np.ones_like(run.run.q))
    assert not run.undriven.any()
    assert not noisy.undriven.any()


def test_a_motion_that_no_command_makes_is_not_planned(monkeypatch: pytest.MonkeyPatch) -> None:
    """A model that runs away on it lies apart from all others by any number."""
    p, options = plan(late()), options_of_late()
    assert max(prospect.left for prospect in options.prospects) < plan_module.ASTRAY
    wild = [replace(options.prospects[0], left=1e6), options.prospects[1]]
    monkeypatch.setattr(plan_module, "family", lambda reach, joints: options.motions[:2])
    monkeypatch.setattr(p, "promised", lambda motions, reach, change=AS_IT_IS: wild[: len(motions)])
    assert p.options().prospects == (wild[1],)


def test_a_joint_that_holds_still_is_held_by_its_torque() -> None:
    """Against more weight than its friction bears; unless something else has held it in all recordings."""
    p = plan(late())
    p.prepared = replace(p.prepared, arm=replace(NOMINAL, gravity=(98.1, 0.0)))
    q = np.full((500, 1), 0.8)
    joint = p.prepared.arm.joints[0]
    weight = 98.1 * joint.mass * (joint.com[0] * np.sin(0.8) + joint.com[1] * np.cos(0.8))
    friction = 1.5 * (joint.friction.C0 + joint.friction.C1)  # as re-tuned, so are masses
    p.candidates = p._candidates(AS_IT_IS)
    assert p.followable(q).tau == pytest.approx(np.full((500, 1), weight), abs=friction)
    held = tuple(replace(run, braked=np.ones(1, dtype=bool)) for run in (*p.prepared.fit, *p.prepared.held))
    p.prepared = replace(p.prepared, fit=held, held=())
    assert np.all(p.followable(q).tau == 0.0)


def test_lag_or_delay_asks_for_a_motion() -> None:
    found = next_of_late()
    assert found.kind == "motion"
    assert set(found.separates) == {"delay", "actuator_lag"}
    assert found.wider == 1.0
    assert found.resolved > WORTH
    assert found.apart >= found.rivals["d_optimal"]
    assert found.apart > found.rivals["random"]
    assert found.apart > 2.0 * late().apart()  # than the recordings so far


@pytest.mark.long
def test_programme_is_put_together_greedily() -> None:
    """Its parts are the options' own, and tell more together than any alone; each criterion is best by its own."""
    options = options_of_late()
    chosen = plan(late()).best(options)
    assert 1 < len(chosen.programme.parts) <= PARTS
    assert set(chosen.programme.parts) <= set(options.motions)
    assert chosen.prospect.worth > max(prospect.worth for prospect in options.prospects)
    classic = plan(late()).classic(options)
    assert classic.prospect.information >= chosen.prospect.information
    assert chosen.prospect.worth >= classic.prospect.worth
    same = plan(late()).at_random(options)
    assert [one.programme for one in same] == [one.programme for one in plan(late()).at_random(options)]


def test_parts_are_joined_within_reach() -> None:
    """From rest to rest, no faster than seen, in the order that takes least."""
    reach = (Reach(-0.4, 1.2, 2.5, 20.0, 1e-4, 8.0), Reach(0.0, 0.5, 1.0, 10.0, 1e-4, 8.0))
    step = 0.004
    parts = (Motion("slow ramp reversals", (0,)), Motion("short moves after ever longer rests", (1,)),
             Motion("a chirp", (0, 1), 0.6))  # fmt: skip
    q = Programme(parts).course(step, reach)
    assert len(q) >= 3 * round(PART / step)
    assert np.all(np.abs(np.diff(q, axis=0)) <= 1.02 * step * np.array([2.5, 1.0]))  # and no jump from part to part
    assert np.all(q >= [-0.4 - 1e-9, -1e-9])
    assert np.all(q <= [1.2 + 1e-9, 0.5 + 1e-9])
    best, duration = shortest(parts, step, reach)
    assert sorted(part.kind for part in best.parts) == sorted(part.kind for part in parts)
    assert duration == pytest.approx(step * (len(best.course(step, reach)) - 1))
    assert duration <= step * (len(q) - 1)


def test_wider_than_recorded() -> None:
    reach = Reach(-0.4, 1.2, 2.5, 20.0, 1e-4, 8.0)
    wider = reach.wider(WIDER)
    assert (wider.low, wider.high, wider.speed) == pytest.approx((-1.2, 2.0, 5.0))
    round_about = Reach(-3.0, 3.0, 2.5, 20.0, 1e-4, 8.0).wider(2.0)
    assert round_about.travel == pytest.approx(2.0 * np.pi)  # no further than half a turn either way


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
    seen = plan(late()).recorded
    assert (seen.low, seen.high) == (pytest.approx(q.min()), pytest.approx(q.max()))
    assert np.abs(reference.dq_ref).max() <= seen.speed <= 1.01 * fastest
    assert "recorded" not in next_of_late().what
    limit = NOMINAL.joints[0].torque_limit
    assert limit is not None
    assert np.abs(reference.tau).max() <= limit
    for end in (0, -1):
        assert abs(reference.dq_ref[end, 0]) < 0.02 * fastest


@pytest.mark.long
def test_moves_between_motions_obey_the_torque_as_well() -> None:
    """As quick as the arm was seen to move, they would ask for twice what a weak arm has."""
    p = plan(late())
    p.limit = 0.2 * p.limit
    chosen = p.best(p.options(WIDER))
    quickest = replace(chosen.programme, slower=1.0).course(p.step, chosen.options.reach)
    assert len(chosen.programme.parts) > 1
    assert np.abs(p.followable(quickest).tau).max() > 1.5 * p.limit
    reference = p.reference(chosen)
    assert np.abs(reference.tau).max() <= p.limit
    assert reference.duration == pytest.approx(p.duration(chosen))
    assert reference.duration <= DURATION


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


@pytest.mark.long
def test_no_motion_tells_an_offset_from_asymmetry() -> None:
    """Along any motion the two laws are the same: so it says, and asks for a change of the drive."""
    p = plan(biased())
    assert p.best(p.options()).apart < 1.0
    found = next_experiment(biased().prepared, biased().models, biased().floor)
    assert found is not None
    assert found.kind == "change"
    assert "polarity" in found.what
    assert found.resolved > 0.9


def test_where_the_cause_may_be_none_of_them_nothing_is_changed() -> None:
    found = next_experiment(biased().prepared, biased().models, biased().floor, as_it_is=True)
    assert found is not None
    assert found.kind == "motion"
    assert found.resolved < 0.1


def test_any_of_the_models_may_be_true() -> None:
    """One that stands out from three that look alike is a quarter of the answer."""
    assert resolved(np.full(3, 30.0)) == pytest.approx(1.0)
    assert resolved(np.array([80.0, 0.0, 0.0, 0.0])) == pytest.approx(0.25, abs=0.02)


def test_reversed_drive_shows_which_it_was() -> None:
    """With its drive reversed the plant's offset turns sign in the joint; the friction of the joint would not."""
    reversed_ = [Injection("torque_offset", "A", {"offset": -0.6})]
    p = plan(biased())
    t = np.arange(0.0, 6.0, p.step)
    kinds = ("slow ramp reversals", "a multisine", "quick reversals")
    runs = [followed(p.followable(Motion(kind, (0,)).course(t, p.seen)), reversed_) for kind in kinds]
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
    done = simulate_loop(NOMINAL, load_loop(tmp_path / "loop.toml", NOMINAL))
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
    assert 0.3 * next_of_late().apart < after.apart() < 2.5 * next_of_late().apart


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
    return [int(model.held[0, 0]) for model in open_question(steps, None if unexplained else set(late().names))]


def test_question_is_asked_only_where_there_is_one() -> None:
    alone, alike, lost = step([0, 0.2, 0.5], 2, (2,)), step([0, 0.4, 0.3, 0.6], 3, (1, 2, 3)), step([0, 0.1, -0.2, 0.3])
    assert asked([alone], unexplained=False) == []
    assert asked([alike], unexplained=False) == [3, 1, 2]
    assert asked([alike, alone], unexplained=False) == [3, 1, 2]
    assert asked([lost], unexplained=True) == [3, 1]  # those that gain at all, the best first
    assert asked([lost, alone], unexplained=True) == [3, 1]  # of the first step
    assert asked([alike, lost], unexplained=True) == [3, 1, 2]  # a class is the question, named or not
    assert asked([step([0, 0.1, -0.2])], unexplained=True) == []


@pytest.mark.long
def test_diagnosis_proposes_and_writes_it(tmp_path) -> None:  # type: ignore[no-untyped-def]
    few = [name for name in registry() if name not in set(late().names)]
    found = diagnose(NOMINAL, recorded(LAG, noise=1e-4), jobs=1, leave_out=few)  # less tells them apart
    assert len(found.named) == 1
    write_diagnosis(found, tmp_path)
    told = json.loads((tmp_path / "diagnosis.json").read_text())["next_experiment"]
    assert told["kind"] == "motion"
    assert set(told["separates"]) == set(found.causes[0].equivalent) == {"delay", "actuator_lag"}
    assert told["expected_gain"]["probability_resolved"] > WORTH
    written = load_run(tmp_path / told["reference"], 1)
    assert written.q_ref is not None
    assert written.dq_ref is not None
    section = next_section(found)
    assert section is not None
    assert dict(section.pairs)["expected gain"].startswith("The likeliest, if it is true, comes out")


def test_a_joint_that_never_moved_is_left_where_it_is() -> None:
    """Nothing is known of its speed, and a part of a range of zero, as ramps over growing distances, is none."""
    locked, moved = Reach(0.3, 0.3, 0.0, 0.0, 1e-4, 8.0), Reach(-0.4, 1.2, 2.5, 20.0, 1e-4, 8.0)
    reach = (moved, locked)
    assert {motion.joints for motion in family(reach, (0, 1))} == {(0,)}
    assert {motion.joints for motion in family((moved, moved), (1,))} == {(1,), (0, 1)}
    assert family((locked,), (0,)) == ()
    programme, _ = shortest([Motion(kind, (0,)) for kind in list(KINDS)[:PARTS]], 0.01, reach)
    course = programme.course(0.01, reach)
    assert np.ptp(course, axis=0)[1] == 0.0 < np.ptp(course, axis=0)[0]
    assert len(course) < DURATION / 0.01 + 2
