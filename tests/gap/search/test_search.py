"""What the search tries, and how it sorts what it has tried."""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from joblib import Parallel

from stribeck.effects.registry import effect_named, registry
from stribeck.gap.diagnose import diagnose
from stribeck.gap.fitted.model import Model, fit_model, retune, start_values, weights_of
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search import beside as beside_module
from stribeck.gap.search import forward as forward_module
from stribeck.gap.search import screen as screen_module
from stribeck.gap.search import screen as screening
from stribeck.gap.search import search as search_module
from stribeck.gap.search import starts as starts_module
from stribeck.gap.search import tryout as tryout_module
from stribeck.gap.search.beside import Idle, misleading, stands_in, weighed, with_together, without_each
from stribeck.gap.search.beside import idle as idle_of
from stribeck.gap.search.candidates import Trial, candidates
from stribeck.gap.search.descent import Descent
from stribeck.gap.search.families import best_laws, best_of_each, close_laws, laws_instead, relawed
from stribeck.gap.search.forward import MOST_ASKED, _survivors
from stribeck.gap.search.gates import LEAST_GAIN
from stribeck.gap.search.judged import Judged, as_hopeful, further_laws
from stribeck.gap.search.ordinary import _needed_of
from stribeck.gap.search.pool import Pool
from stribeck.gap.search.projector import Projector
from stribeck.gap.search.rank import rank
from stribeck.gap.search.screen import _loudest, screen
from stribeck.gap.search.setting import Asked, Setting
from stribeck.gap.search.starts import from_every_start
from stribeck.gap.search.step import Step
from stribeck.gap.search.tryout import Tryout, _fit_trial, _states
from stribeck.gap.search.tuned import Retuned
from stribeck.identify import machine as machine_module
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.model import cut as cut_module
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath
from stribeck.model.scale import Scale

from ..conftest import NOMINAL, TRUE, recorded

FLOOR = np.array([0.02])
SCALE = Scale(torque=4.0, friction=2.0, speed=1.0, travel=2.0, inertia=0.3, sample_time=0.01, length=0.3)


@pytest.fixture(scope="module")
def late() -> tuple[Prepared, Model, Weights]:
    """A drive that is 20 ms late, and what re-tuning leaves of it."""
    prepared = prepare(NOMINAL, recorded(("delay", {"time": 0.02})))
    base = retune(prepared, FLOOR)
    return prepared, base, weights_of(base, prepared, FLOOR)


def test_candidates() -> None:
    found = [effect for effect, _ in candidates(TRUE, ())]
    names = [effect.name for effect in found]
    assert len(found) == len({effect.label for effect in found})
    assert names.count("presliding") == 3  # every law of a family
    assert "negative_damping" not in names  # the nominal model has a falling part
    assert set(names) <= set(registry())
    assert not any(effect.direct for effect in found)  # no torque shows them
    assert {"delay", "payload", "backlash"} <= set(names)


def test_candidates_left_out_or_taken() -> None:
    placed = [Placed(effect_named("delay"), 0)]
    names = [effect.name for effect, _ in candidates(TRUE, placed, ("payload",))]
    assert "payload" not in names
    assert "delay" not in names


@pytest.mark.parametrize(("there", "gone"), [("backlash", "joint_flexibility"), ("joint_flexibility", "backlash")])
def test_one_compliance_a_joint(there: str, gone: str) -> None:
    names = [effect.name for effect, _ in candidates(TRUE, [Placed(effect_named(there), 0)])]
    assert gone not in names
    assert "presliding" in names


def test_of_a_family_the_law_that_promises_most() -> None:
    one, other = effect_named("presliding", "lugre"), effect_named("presliding", "maxwell_slip")
    tried = [Trial(one, 0, {}, 3.0), Trial(other, 0, {}, 4.0), Trial(one, 1, {}, 3.0), Trial(other, 1, {}, 3.0)]
    kept = best_laws([*tried, Trial(effect_named("delay"), 0, {}, 1.0)])
    assert [(trial.effect.label, trial.joint) for trial in kept] == [
        ("presliding/maxwell_slip", 0), ("presliding/lugre", 1), ("delay", 0)
    ]  # fmt: skip


def test_laws_of_a_family_that_take_as_much_are_both_fitted() -> None:
    """Where they take most of the gap; else what tells them apart is in the gap itself."""
    one, other, third = (
        effect_named("presliding", "lugre"),
        effect_named("presliding", "maxwell_slip"),
        effect_named("delay"),
    )
    kept = [Trial(one, 0, {}, 9.0), Trial(third, 0, {}, 9.5)]
    close, far = Trial(other, 0, {}, 8.5), Trial(other, 0, {}, 5.0)
    assert close_laws([*kept, close], kept, np.array([10.0, 100.0])) == [close]
    assert close_laws([*kept, far], kept, np.array([10.0, 1.0])) == []
    assert close_laws([*kept, close], kept, np.array([30.0, 1.0])) == []
    assert close_laws([*kept, Trial(other, 1, {}, 9.0)], kept, np.full(2, 10.0)) == []  # at a joint where none was kept


def test_a_law_is_tried_again_once_another_effect_is_there() -> None:
    """Two poles and an offset, of which one pole was taken first."""
    prepared = prepare(
        NOMINAL, recorded(("actuator_lag", {"time": 0.015, "again": 0.015}), ("torque_offset", {"offset": 1.0}))
    )
    base = retune(prepared, FLOOR)
    weights = weights_of(base, prepared, FLOOR)
    first, second = effect_named("actuator_lag", "one_pole"), effect_named("actuator_lag", "two_poles")
    known = {(e.name, e.law, 0): dict(screen(prepared, base, weights, e, 0).start) for e in (first, second)}
    placed = (
        Placed(first, 0, known[first.name, first.law, 0]),
        Placed(effect_named("torque_offset"), 0, {"offset": 1.0}),
    )
    model = fit_model(prepared, placed, weights)
    with Parallel(n_jobs=1) as pool:
        found = relawed(prepared, FLOOR, pool, model, 0, known)
        assert [place.effect.label for place in found.placed] == ["actuator_lag/two_poles", "torque_offset"]
        assert found.rms()[0] < 0.8 * model.rms()[0]
        assert relawed(prepared, FLOOR, pool, found, 0, known) is found
        assert relawed(prepared, FLOOR, pool, model, 1, known) is model  # not of the nominal model's own


def test_a_law_is_not_tried_where_a_later_effect_has_its_place() -> None:
    """A base that slides leaves room for a soft shaft at the first joint; one that rocks is itself the compliance."""
    sliding, rocking = (effect_named("base_flexibility", law) for law in ("sliding", "rocking"))
    model: Any = SimpleNamespace(placed=(Placed(sliding, 0), Placed(effect_named("joint_flexibility"), 0)))
    known = {("base_flexibility", "rocking", 0): rocking.starts(SCALE)[0]}
    prepared: Any = None
    assert relawed(prepared, FLOOR, None, model, 0, known) is model


def test_another_law_must_do_better_on_held_out_runs_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    lags = {law: effect_named("actuator_lag", law) for law in ("one_pole", "two_poles")}

    def fitted(law: str, left: float, held: float) -> Any:
        placed = (Placed(lags[law], 0, {"time_constant": 0.01}), Placed(effect_named("torque_offset"), 0))
        rows = np.full((10, 1), left)
        fit: Any = SimpleNamespace(residual=rows)
        return Model(tuple(placed), fit, np.full((10, 1), held))

    model, prepared = fitted("one_pole", 1.0, 1.0), SimpleNamespace(scales=(None,))
    known = {("actuator_lag", "two_poles", 0): {"time_constant": 0.01}}
    monkeypatch.setattr("stribeck.gap.search.families.weights_of", lambda *given: None)
    for held, law in ((0.9, "two_poles"), (1.1, "one_pole")):
        other = fitted("two_poles", 0.5, held)
        kept = relawed(prepared, FLOOR, lambda fits, other=other: [other for _ in fits], model, 0, known)  # type: ignore[arg-type]
        assert kept.placed[0].effect.law == law


def test_screen_promises_what_the_fit_keeps(late: tuple[Prepared, Model, Weights]) -> None:
    """The true effect promises most of the cost, its screened value is near, and the fit delivers the promise."""
    prepared, base, weights = late
    trial = screen(prepared, base, weights, effect_named("delay"), 0)
    assert trial.key == ("delay", 0)
    assert trial.start["time"] == pytest.approx(0.02, rel=0.15)
    fitted = fit_model(prepared, [Placed(trial.effect, 0)], weights, base.fit, trial.start)
    assert fitted.fit.ok
    saved = base.fit.cost - fitted.fit.cost
    assert trial.promise > 0.5 * base.fit.cost
    assert trial.promise == pytest.approx(saved, rel=0.2)
    assert fitted.placed[0].values["time"] == pytest.approx(0.02, rel=0.06)
    assert fitted.rms()[0] < 0.4 * base.rms()[0]
    again = retune(prepared, FLOOR, fitted.placed, rounds=2)  # with weights of its own
    assert again.placed[0].values["time"] == pytest.approx(0.02, rel=0.03)


@pytest.mark.parametrize(
    ("near", "left", "passing", "found"),
    [
        (0.9, 9.0, (1, 2), ("actuator_lag", 0)),
        (0.5, 9.0, (1, 2), None),  # the delay is far behind
        (0.9, 1.5, (1, 2), None),  # hardly more than noise is left
        (0.9, 9.0, (1,), None),  # the delay may not be taken
    ],
)
def test_an_effect_that_leaves_much_may_stand_for_another(
    near: float, left: float, passing: tuple[int, ...], found: tuple[str, int] | None
) -> None:
    lag, late = (SimpleNamespace(placed=(Placed(effect_named(name), 0),)) for name in ("actuator_lag", "delay"))
    models: Any = (lag, late)
    ranking: Any = SimpleNamespace(
        best=1, overall=np.array([0.0, 0.95, near]), power=np.array([[90.0], [left], [20.0]])
    )
    base: Any = SimpleNamespace(placed=())
    took = Step(base, models, ranking, passing, (), FLOOR)
    ended = Step(base, models, ranking, (), (), FLOOR)
    assert misleading((took, ended)) == found
    assert misleading((took, took, ended)) is None
    assert misleading((took,)) is None  # nothing was tried beside it


@pytest.mark.parametrize(("stiffness", "inertia"), [(150.0, 0.4), (300.0, 0.5), (400.0, 1.0)])
def test_a_resonance_between_the_starts_is_found(stiffness: float, inertia: float) -> None:
    """Starts that run away to a rigid base lose nothing, and must not crowd out the one that leads down."""
    hidden = {"stiffness": stiffness, "inertia": inertia, "damping": 1.0}
    prepared = prepare(NOMINAL, recorded(("base_flexibility", hidden)))
    base = retune(prepared, FLOOR)
    weights = weights_of(base, prepared, FLOOR)
    trial = screen(prepared, base, weights, effect_named("base_flexibility"), 0)
    assert trial.start["stiffness"] == pytest.approx(stiffness, rel=0.3)
    assert trial.promise > 0.5 * base.fit.cost


def test_a_start_is_followed_for_where_it_leads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a start at the resonance: one not far from it leads down, though others have run away to no loss."""
    monkeypatch.setattr("stribeck.effects.rigid_body.base_flexibility.ringing", lambda trace, span: [])
    hidden = {"stiffness": 100.0, "inertia": 1.2, "damping": 1.0}
    prepared = prepare(NOMINAL, recorded(("base_flexibility", hidden)))
    base = retune(prepared, FLOOR)
    weights = weights_of(base, prepared, FLOOR)
    assert screen(prepared, base, weights, effect_named("base_flexibility"), 0).promise > 0.4 * base.fit.cost


def test_a_start_that_ends_as_another_law_stands_back(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A play that has closed is a spring, which is tried itself: what stays a play is taken, though it saves less."""
    ends = iter([(1e-6, 5.0), (0.02, 3.0)])

    def go(way: Descent, steps: int) -> None:
        way.saved, way.ahead = 0.0, 0.0
        if steps == screening.STEPS:
            way.p = way.p.copy()
            way.p[way._own[0]], way.saved = next(ends)

    monkeypatch.setattr(Descent, "go", go)
    prepared, base, weights = late
    trial = screen(prepared, base, weights, effect_named("backlash"), 0)
    assert (trial.start["gap"], trial.promise) == (0.02, 3.0)


def test_a_law_that_runs_away_leads_nowhere(late: tuple[Prepared, Model, Weights]) -> None:
    """An unstable law's residual is finite and its squares are not."""
    prepared, base, weights = late
    path = SignalPath(prepared.arm, (*base.placed, Placed(effect_named("delay"), 0)))
    own = [i for i, entry in enumerate(path.entries) if entry.owner == len(base.placed)]
    residual = Residual(path, prepared.fit, own)
    away: Any = type(
        "Away", (), {"path": path, "__call__": lambda self, p: tuple(1e200 * part for part in residual(p))}
    )
    projector = Projector(base.fit, weights, np.arange(len(base.fit.residual)))
    start = start_values(path, base.fit, {"time": 0.01})
    near, far = (Descent(which, projector, start, own, np.ones(1)) for which in (residual, away()))
    near.go(1)
    far.go(3)
    assert near.saved > 0.0
    assert far.saved == far.ahead == -np.inf


@pytest.mark.parametrize("time", [0.012, 0.06], ids=["below the base", "above it"])
def test_a_fit_that_was_stopped_short_goes_on(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch, time: float
) -> None:
    """From where it is; where that is worse than no effect at all, from there."""
    prepared, base, weights = late
    trial = replace(screen(prepared, base, weights, effect_named("delay"), 0), start={"time": time})
    stopped: list[Model] = []

    def fit_once(*known: Any, evaluations: int) -> Model:
        model = fit_model(*known, evaluations=evaluations if stopped else 0)
        stopped.append(model)
        return model

    monkeypatch.setattr(tryout_module, "fit_model", fit_once)
    fitted = _fit_trial(prepared, base, weights, trial, FLOOR)
    assert (stopped[0].fit.cost > base.fit.cost) is (time > 0.05)
    assert not stopped[0].fit.ok
    assert fitted is not None
    assert fitted.by_own_weights.placed[0].values["time"] == pytest.approx(
        trial_time(prepared, base, weights), rel=0.05
    )


@pytest.mark.parametrize(("name", "goes_on"), [("torque_gain", True), ("delay", False)])
def test_what_a_law_spares_the_prior_is_no_part_of_its_promise(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch, name: str, goes_on: bool
) -> None:
    """A stopped fit that has found more than was promised goes on, for a law that spares the nominal values."""
    prepared, base, weights = late
    trial = screen(prepared, base, weights, effect_named(name), 0)
    asked: list[int] = []

    def fit_once(prepared: Prepared, placed: Any, *_: Any, evaluations: int) -> Any:
        asked.append(evaluations)
        ok = evaluations == tryout_module.LONGER
        cost = base.fit.cost - 2.0 * trial.promise
        fit: Any = SimpleNamespace(cost=cost, ok=ok, residual=base.fit.residual)
        return Model((Placed(trial.effect, 0, trial.start),), fit, base.held)

    monkeypatch.setattr(tryout_module, "fit_model", fit_once)
    assert _fit_trial(prepared, base, weights, trial, FLOOR) is not None
    assert (tryout_module.LONGER in asked) is goes_on


def trial_time(prepared: Prepared, base: Model, weights: Weights) -> float:
    """The delay as a fit from a good start finds it, s."""
    trial = screen(prepared, base, weights, effect_named("delay"), 0)
    return fit_model(prepared, [Placed(trial.effect, 0)], weights, base.fit, trial.start).placed[0].values["time"]


@pytest.mark.parametrize(
    ("promise", "best", "cost"),
    [(1.0, 9.0, 9.0), (0.1, 9.0, 50.0), (1.0, 70.0, 50.0)],
    ids=["better", "faint", "no better"],
)
def test_a_law_that_ends_where_it_cannot_be_meant_starts_elsewhere(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch, promise: float, best: float, cost: float
) -> None:
    """The best of its starts is taken that ends where it can be meant, if that is better and the gap is worth it."""
    prepared, base, weights = late
    shaft = effect_named("joint_flexibility")
    starts = shaft.starts(prepared.scales[0])
    ends = {start["stiffness"]: 80.0 for start in starts} | {starts[1]["stiffness"]: best, starts[2]["stiffness"]: 2.0}
    damped = {"stiffness": 7.0, "damping": 1e4}

    def fit_once(prepared: Prepared, placed: Any, weights: Weights, known: Any, start: Any = None, **_: Any) -> Any:
        values = placed[-1].values if start is None else start
        fit: Any = SimpleNamespace(cost=ends.get(values["stiffness"], 50.0), ok=True, residual=np.zeros((3, 1)))
        values = {**values, "damping": 1e4} if values["stiffness"] == starts[2]["stiffness"] else values
        return Model((Placed(shaft, 0, values),), fit, np.zeros((3, 1)))

    setting = Setting(prepared, FLOOR, 0, Pool(1), (), frozenset(), lambda text: None)
    tryout = Tryout(setting, base, {})
    tryout.cost = np.ones(1)
    monkeypatch.setattr(tryout_module, "fit_model", fit_once)
    monkeypatch.setattr(starts_module, "fit_model", fit_once)
    monkeypatch.setattr(tryout_module, "weights_of", lambda *_: weights)
    (model,) = tryout.fitted([Trial(shaft, 0, damped, promise)])
    assert model is not None
    assert model.fit.cost == cost
    assert shaft.plausible(model.placed[0].values, prepared.scales[0]) is (cost < 50.0)


@pytest.mark.parametrize("left", [0.5, 2.0])
def test_nothing_starts_elsewhere_where_another_law_leaves_no_more_than_noise(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch, left: float
) -> None:
    """In noise floors."""
    prepared, base, weights = late
    damped, delay = {"stiffness": 7.0, "damping": 1e4}, {"time": 0.012}
    trials = [Trial(effect_named("joint_flexibility"), 0, damped, 1.0), Trial(effect_named("delay"), 0, delay, 1.0)]
    elsewhere: list[Any] = []

    def fit_once(prepared: Prepared, placed: Any, weights: Weights, known: Any, start: Any, **_: Any) -> Any:
        fit: Any = SimpleNamespace(cost=50.0, ok=True, residual=np.full((3, 1), left * FLOOR[0]))
        return Model((Placed(placed[-1].effect, 0, start),), fit, fit.residual)

    def ends(*given: Any) -> list[list[Model]]:
        elsewhere.extend(effect.name for effect, _ in given[3])
        return [[] for _ in given[3]]

    tryout = Tryout(Setting(prepared, FLOOR, 0, Pool(1), (), frozenset(), lambda text: None), base, {})
    tryout.cost = np.ones(1)
    monkeypatch.setattr(tryout_module, "fit_model", fit_once)
    monkeypatch.setattr(tryout_module, "ends", ends)
    monkeypatch.setattr(tryout_module, "weights_of", lambda *_: weights)
    assert None not in tryout.fitted(trials)
    assert elsewhere == (["joint_flexibility"] if left > 1.0 else [])


def test_of_every_start_the_nearest_that_can_be_meant_are_followed(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither what a few steps bring below the others but to nothing that can be meant, nor what runs away."""
    prepared, _, weights = late
    base: Any = SimpleNamespace(placed=(), fit=SimpleNamespace(cost=12.0))
    play = effect_named("backlash")
    starts = play.starts(prepared.scales[0])
    spring, away, second, first = (start["gap"] for start in starts[:4])
    near, ends = {spring: 1.0, away: 0.0, second: 8.0, first: 7.0}, {second: 2.0, first: 3.0}
    followed: list[float] = []

    def fit_once(prepared: Prepared, placed: Any, weights: Weights, known: Any, start: Any = None, **_: Any) -> Any:
        values = dict(placed[-1].values if start is None else start)
        gap = values["gap"]
        if start is None:
            followed.append(gap)
        held = np.full((3, 1), np.nan if gap == away else 0.0)
        fit: Any = SimpleNamespace(cost=near.get(gap, 9.0) if start else ends[gap], ok=True, residual=held)
        ended = values | ({"gap": 0.0} if gap == spring else {})
        return Model((Placed(play, 0, ended),), fit, held)

    monkeypatch.setattr(starts_module, "fit_model", fit_once)
    with Parallel(n_jobs=1) as pool:
        (model,) = from_every_start(prepared, base, weights, [(play, 0)], pool)
    assert followed[:2] == [first, second]
    assert model is not None
    assert model.placed[-1].values["gap"] == second  # it came further
    assert set(followed) == {first, second}
    followed.clear()
    base.fit.cost = 1.2  # not one start does a good part of it
    with Parallel(n_jobs=1) as pool:
        assert from_every_start(prepared, base, weights, [(play, 0)], pool) == [None]
    assert followed == []


@pytest.mark.parametrize(
    ("tried", "part", "found"),
    [("delay", 0.1, set()), ("cable_spring", 0.4, {"backlash"}), ("cable_spring", 0.6, set())],
    ids=["little is left", "it does far better", "it does not"],
)
def test_where_much_is_left_compliances_are_fitted_from_every_start(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch, tried: str, part: float, found: set[str]
) -> None:
    prepared, base, weights = late
    trial = screen(prepared, base, weights, effect_named(tried), 0)
    monkeypatch.setattr(tryout_module, "screen", lambda *_: trial)
    monkeypatch.setattr(forward_module, "_survivors", lambda tried, strained: [trial])

    def fitted(prepared: Prepared, base: Model, weights: Weights, effect: Effect, joint: int) -> Model:
        start = Placed(effect, joint, effect.starts(prepared.scales[joint])[0])
        left = part if effect.name == "backlash" else 1.0
        residual = left * base.fit.residual
        return replace(base, placed=(start,), fit=replace(base.fit, residual=residual), held=left * base.held)

    def each(prepared: Prepared, base: Model, weights: Weights, wanted: Any, pool: object) -> list[Model]:
        return [fitted(prepared, base, weights, *one) for one in wanted]

    monkeypatch.setattr(tryout_module, "from_every_start", each)
    monkeypatch.setattr(tryout_module, "_by_own_weights", lambda prepared, model, weights, floor: model)
    with Parallel(n_jobs=1) as pool:
        setting = Setting(prepared, FLOOR, 0, pool, (), frozenset(), lambda text: None)
        step = forward_module._step(setting, Tryout(setting, base, {}), (), None)
    assert {model.placed[-1].effect.name for model in step.rivals} == {tried} | found


def test_a_large_gap_is_weighed_anew_as_it_closes() -> None:
    """Against a residual that is all gap, close tolerances count for more than the rows; they must not for good."""
    tight = replace(NOMINAL, tolerance=replace(NOMINAL.tolerance, friction=0.1))
    prepared = prepare(tight, recorded(("asymmetric_friction", {"C0": 4.0})))
    base = retune(prepared, FLOOR)
    weights = weights_of(base, prepared, FLOOR)
    trial = screen(prepared, base, weights, effect_named("asymmetric_friction"), 0)
    once = fit_model(prepared, [Placed(trial.effect, 0)], weights, base.fit, trial.start)
    fitted = _fit_trial(prepared, base, weights, trial, FLOOR)
    assert fitted is not None
    model = fitted.by_own_weights
    assert model.rms()[0] < 0.8 * once.rms()[0]
    assert model.placed[0].values["coulomb"] == pytest.approx(2.0, rel=0.1)


def test_a_fit_that_is_stopped_while_it_falls_goes_on_by_its_own_weights(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its weights hold before it has come to its end; one that has come there, or falls no more, is done."""
    prepared, base, weights = late
    for ok, falls, rounds in ((False, 0.8, tryout_module.AGAIN), (True, 0.8, 1), (False, 0.99, 1)):
        made: list[Model] = []

        def again(_: Prepared, placed: object, own: Weights, fit: Any, ok: bool = ok, falls: float = falls,
                  made: list[Model] = made, **__: int) -> Model:  # fmt: skip
            status = "Solve_Succeeded" if ok else "User_Requested_Stop"
            made.append(replace(base, fit=replace(base.fit, residual=falls * fit.residual, status=status)))
            return made[-1]

        first = replace(weights, sd=0.5 * weights.sd)
        monkeypatch.setattr(tryout_module, "fit_model", again)
        monkeypatch.setattr(tryout_module, "weights_of", lambda *_, first=first: first)
        found = tryout_module._by_own_weights(prepared, base, weights, FLOOR)
        assert found is made[-1]
        assert len(made) == rounds


@pytest.mark.parametrize(("gain", "ends"), [(0.1, True), (0.6, False)])
def test_the_search_goes_on_after_a_large_gain(monkeypatch: pytest.MonkeyPatch, gain: float, ends: bool) -> None:
    """What is doubtful because much is left may be what hides the next one."""
    monkeypatch.setattr(forward_module, "evidence", lambda step: forward_module.CENTRE)
    monkeypatch.setattr(forward_module, "presence", lambda seen: 0.1)
    step = SimpleNamespace(ranking=SimpleNamespace(overall=np.array([0.0, gain]), best=1))
    assert forward_module.hardly(step) is ends


def test_what_is_left_does_not_end_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """It may be the gap of an effect that is found next."""
    centre = forward_module.CENTRE
    monkeypatch.setattr(forward_module, "evidence", lambda step: replace(centre, left=centre.left + 3.0))
    monkeypatch.setattr(forward_module, "presence", lambda seen: 0.5 if seen.left == centre.left else 0.01)
    step = SimpleNamespace(ranking=SimpleNamespace(overall=np.array([0.0, 0.1]), best=1))
    assert not forward_module.hardly(step)


def test_a_law_that_rests_on_a_bound_gives_way_to_one_that_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """Though it leaves less; of two sound laws the one that leaves less is kept."""

    def fitted(law: str, left: float) -> SimpleNamespace:
        place = Placed(effect_named("actuator_lag", law), 0, {"time_constant": 0.01})
        return SimpleNamespace(placed=(place,), whole=np.full((10, 1), left))

    models, scales = [fitted("one_pole", 1.0), None, fitted("two_poles", 0.5)], SimpleNamespace(scales=(None,))
    kept = best_of_each(models, scales, FLOOR)  # type: ignore[arg-type]
    assert [model.placed[0].effect.law for model in kept] == ["two_poles"]
    monkeypatch.setattr("stribeck.gap.search.families.holds", lambda place, scale: place.effect.law != "two_poles")
    kept = best_of_each(models, scales, FLOOR)  # type: ignore[arg-type]
    assert [model.placed[0].effect.law for model in kept] == ["one_pole"]


def test_a_law_that_bends_to_fitted_runs_is_not_the_best_of_its_family() -> None:
    """Its law of the distance left less of friction's heat on fitted runs, and twice as much as none on the others."""

    def fitted(law: str, fit: float, held: float) -> SimpleNamespace:
        place = Placed(effect_named("history", law), 0, {"change": 0.1})
        rows = np.array([[fit]] * 10 + [[held]] * 5)
        return SimpleNamespace(placed=(place,), fit=SimpleNamespace(residual=rows[:10]), whole=rows)

    models, scales = [fitted("warm_up", 0.3, 2.0), fitted("heat", 0.4, 0.4)], SimpleNamespace(scales=(SCALE,))
    kept = best_of_each(models, scales, FLOOR)  # type: ignore[arg-type]
    assert [model.placed[0].effect.law for model in kept] == ["heat"]


def test_where_a_law_leaves_much_the_others_of_its_family_are_fitted(late: tuple[Prepared, Model, Weights]) -> None:
    """Not those of another joint or family, that were fitted, or that promise less than half."""
    _, base, _ = late
    taken, other = (effect_named("history", law) for law in ("thixotropy", "heat"))
    third = effect_named("history", "in_time")
    place = Placed(taken, 0, taken.starts(SCALE)[0])
    ranking = SimpleNamespace(best=1, power=np.array([[90.0, 1.0], [5.0, 9.0]]))
    judged = Judged([replace(base, placed=(place,))], ranking, (1,), FLOOR)  # type: ignore[arg-type]
    own, heat = Trial(taken, 0, {}, 9.0), Trial(other, 0, {}, 5.0)
    tried = [own, heat, Trial(third, 0, {}, 4.0), Trial(other, 1, {}, 9.0), Trial(effect_named("delay"), 0, {}, 8.0)]
    assert further_laws(tried, {own.law_key}, judged) == [heat]
    assert further_laws(tried, {own.law_key, heat.law_key}, judged) == []
    assert further_laws(tried, {own.law_key}, judged._replace(passing=())) == []
    ranking.power[1, 0] = 3.9
    assert further_laws(tried, {own.law_key}, judged) == []


def test_where_no_law_holds_that_takes_the_gap_the_family_has_others_to_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not where one holds and leaves less; nor what takes little, is at another joint, or promises less than half."""
    one, other = effect_named("dwell_time", "ageing"), effect_named("dwell_time", "break_away")
    first, second = Trial(one, 0, {}, 9.0), Trial(other, 0, {}, 6.0)
    tried = [first, second, Trial(other, 1, {}, 9.0), Trial(effect_named("delay"), 0, {}, 8.0)]
    placed = (Placed(one, 0, one.starts(SCALE)[0]),)
    base: Any = SimpleNamespace(whole=np.full((9, 1), 1.0))
    model: Any = SimpleNamespace(placed=placed, whole=0.5 * base.whole)
    lost: Any = SimpleNamespace(placed=placed, whole=0.99 * base.whole)  # the fit has gone astray, wherever it started
    prepared: Any = SimpleNamespace(scales=(SCALE, SCALE))
    cost = np.array([10.0, 10.0])

    def others(found: Any, cost: np.ndarray = cost, tried: Sequence[Trial] = tried) -> list[Trial]:
        return laws_instead(tried, found, cost, base, prepared, FLOOR)

    assert others({first.law_key: model}) == []
    assert others({first.law_key: None}) == [second]
    assert others({first.law_key: lost}) == [second]
    monkeypatch.setattr("stribeck.gap.search.families.holds", lambda place, scale: False)
    assert others({first.law_key: model}) == [second]
    little: Any = SimpleNamespace(placed=placed, whole=0.9 * base.whole)
    assert others({first.law_key: little}, 3.0 * cost) == []
    assert others({first.law_key: model}, 3.0 * cost) == [second]  # which promised little, and took most of it
    assert others({first.law_key: model, second.law_key: model}) == []
    for promise in (4.0, -1.0, -np.inf):
        assert others({first.law_key: model}, tried=[first, Trial(other, 0, {}, promise)]) == []


def test_the_laws_tried_instead_are_fitted(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch
) -> None:
    prepared, base, _ = late
    spring = effect_named("cable_spring")
    other = Trial(spring, 0, spring.starts(prepared.scales[0])[0], 1.0)
    late_drive = Trial(effect_named("delay"), 0, {"time": 0.01}, 2.0)
    monkeypatch.setattr(tryout_module, "screen", lambda *_: late_drive)
    monkeypatch.setattr(forward_module, "_survivors", lambda tried, strained: [late_drive])
    monkeypatch.setattr(forward_module, "laws_instead", lambda *_: [other])
    with Parallel(n_jobs=1) as pool:
        setting = Setting(prepared, FLOOR, 0, pool, (), frozenset(), lambda text: None)
        step = forward_module._step(setting, Tryout(setting, base, {}), (), None)
    assert {model.placed[-1].effect.name for model in step.rivals} == {"delay", "cable_spring"}


@pytest.mark.parametrize("wrong", ["payload", "cable_spring", "cogging", "load_dependent_friction"])
def test_wrong_effect_promises_little(late: tuple[Prepared, Model, Weights], wrong: str) -> None:
    prepared, base, weights = late
    true, other = (screen(prepared, base, weights, effect_named(name), 0) for name in ("delay", wrong))
    assert other.promise < 0.3 * true.promise


def test_known_values_are_the_start(late: tuple[Prepared, Model, Weights]) -> None:
    prepared, base, weights = late
    trial = screen(prepared, base, weights, effect_named("delay"), 0, {"time": 0.019})
    assert trial.start["time"] == pytest.approx(0.02, rel=0.06)


def test_weights_are_spread_and_correlation(late: tuple[Prepared, Model, Weights]) -> None:
    prepared, base, weights = late
    rms = np.sqrt(np.mean(base.fit.residual**2, axis=0))
    assert weights.sd == pytest.approx(np.full_like(base.fit.residual, rms[0]))
    assert weights.correlation[0] > 2.0  # a late torque leaves a coloured residual
    assert weights_of(base, prepared, np.array([50.0])).sd == pytest.approx(np.full_like(base.fit.residual, 50.0))


def test_retuning_starts_from_nominal_and_improves(late: tuple[Prepared, Model, Weights]) -> None:
    from stribeck.identify.residual import Residual
    from stribeck.model.layout import values_of
    from stribeck.model.path import SignalPath

    prepared, base, _ = late
    path = SignalPath(NOMINAL)
    nominal = Residual(path, prepared.held, ())(values_of(path.entries))[0]
    assert base.fit.ok
    assert base.rms()[0] < np.sqrt(np.mean(nominal**2))


def test_screening_comes_down_from_a_far_start(late: tuple[Prepared, Model, Weights]) -> None:
    """A step that makes things worse is taken back, so that a start ten times too small ends where a near one does."""
    prepared, base, weights = late
    found = screen(prepared, base, weights, effect_named("delay"), 0, {"time": 0.002})
    near = screen(prepared, base, weights, effect_named("delay"), 0, {"time": 0.019})
    assert found.promise == pytest.approx(near.promise, rel=0.05)
    assert found.start["time"] == pytest.approx(0.02, rel=0.1)


def test_one_law_of_a_family_at_a_joint_and_one_stand_an_arm() -> None:
    arm = replace(NOMINAL, joints=(NOMINAL.joints[0], replace(NOMINAL.joints[0], name="B")))

    def offered(*placed: Placed) -> set[tuple[str, int]]:
        return {(effect.label, joint) for effect, joint in candidates(arm, placed)}

    stop, plane = effect_named("contact", "linear"), effect_named("contact", "plane")
    assert {("contact/plane", 0), ("contact/linear", 1)} <= offered()
    assert not {label for label, _ in offered(Placed(plane, 0)) if label.startswith("contact/")}
    beside = {place for place in offered(Placed(stop, 1)) if place[0].startswith("contact/")}
    assert beside == {("contact/linear", 0), ("contact/hunt_crossley", 0)}
    slides = Placed(effect_named("base_flexibility", "sliding"), 0)
    assert not {label for label, _ in offered(slides) if label.startswith("base_flexibility")}
    assert ("joint_flexibility", 0) in offered(slides)


def test_laws_beside_strained_values_are_fitted_in_any_case() -> None:
    """Beside a constant at its limit an encoder's offset promised a quarter of a gap, and closed all of it once fitted.

    Not those that take long, nor what has no promise at all.
    """
    tried = [Trial(effect_named("delay"), 0, {}, 9.0 + k) for k in range(9)]
    little = [Trial(effect_named(name), 0, {}, -0.01) for name in ("payload", "encoder_offset", "dwell_time")]
    slow = [Trial(effect_named(name), 0, {}, 0.01) for name in ("presliding", "backlash")]
    lost = Trial(effect_named("cogging"), 0, {}, -np.inf)
    every = [*tried, *little, *slow, lost]
    assert not {"payload", "encoder_offset", "dwell_time"} & {t.effect.name for t in _survivors(every, strained=False)}
    kept = _survivors(every, strained=True)
    assert all(trial in kept for trial in little)
    plain = [effect for effect in registry().values() if not effect.nonlinear and not effect.rescales]
    many = [Trial(effect, joint, {}, 0.01 * k) for joint in (0, 1, 2) for k, effect in enumerate(plain)]
    heavy = Trial(effect_named("payload"), 0, {}, -9.0)
    few, most = (_survivors([*many, *tried, heavy], strained=strained) for strained in (False, True))
    assert len(most) == len(few) + MOST_ASKED < len(many)
    assert heavy in most  # which strained values mimic
    left_out = max(trial.promise for trial in many if trial not in most)
    assert left_out <= min(trial.promise for trial in most if trial not in few and trial is not heavy)
    assert not [trial for trial in kept if trial in slow or trial is lost]
    assert len({id(trial) for trial in kept}) == len(kept)


def test_compliances_do_not_crowd_out_what_promises_less() -> None:
    laws = "joint_flexibility", "backlash"
    compliances = [Trial(effect_named(name), joint, {}, 300.0 - joint) for name in laws for joint in range(6)]
    compliances.append(Trial(effect_named("base_flexibility", "sliding"), 0, {}, 400.0))
    there = [Trial(effect_named("position_dependent_friction"), 2, {}, 90.0 - k) for k in range(3)]
    rest = [Trial(effect_named("delay"), joint, {}, 2.0 + 0.1 * joint) for joint in range(6)]
    kept = _survivors([*compliances, *there, *rest], strained=False)
    assert all(trial in kept for trial in there)
    assert [trial for trial in kept if trial in compliances] == sorted(compliances, key=lambda t: -t.promise)[:8]
    assert len(kept) == len({(trial.key, trial.promise) for trial in kept})


def test_half_of_the_runs_that_says_most(late: tuple[Prepared, Model, Weights]) -> None:
    prepared, base, weights = late
    quiet = np.full(1, 1e-3)
    lengths = [len(run.analysis_index) for run in prepared.fit]
    loud = np.repeat([0.0, 1.0, 2.0][: len(lengths)], lengths)[:, None]
    fit = replace(base.fit, residual=loud * quiet)
    assert _loudest(prepared, replace(base, fit=fit), weights) == [1, 2]


@pytest.mark.parametrize(("beside", "name", "some"), [(0, "delay", False), (0, "presliding", True), (1, "delay", True)])
def test_what_takes_long_is_screened_along_some_runs(
    monkeypatch: pytest.MonkeyPatch, beside: int, name: str, some: bool
) -> None:
    """A law that does, and any law beside a play."""
    prepared = prepare(NOMINAL, recorded(("delay", {"time": 0.012})))
    play = Placed(effect_named("backlash"), 0, {"gap": 0.01, "stiffness": 700.0, "damping": 1.0})
    placed = [play][:beside]
    base = fit_model(prepared, placed, weights_of(retune(prepared, FLOOR), prepared, FLOOR), evaluations=1)
    asked: list[int] = []

    def few(prepared: Prepared, base: Model, weights: Weights) -> list[int]:
        asked.append(len(prepared.fit))
        return _loudest(prepared, base, weights)

    monkeypatch.setattr(screen_module, "_loudest", few)
    screen(prepared, base, weights_of(base, prepared, FLOOR), effect_named(name), 0)
    assert bool(asked) is some


@pytest.mark.parametrize(
    "name", ["torque_offset", pytest.param("encoder_eccentricity", marks=pytest.mark.slow), "presliding"]
)
def test_known_states_change_no_trial(
    late: tuple[Prepared, Model, Weights], name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether or not a candidate has a say in the states that the base model has, the trial is the same.

    Nearly, where the link's observer would follow what the candidate changes of the residual.
    """
    prepared, base, weights = late
    assert _states(prepared, base) is None
    flexible = fit_model(prepared, [Placed(effect_named("joint_flexibility"), 0)], weights, base.fit, evaluations=5)
    states = _states(prepared, flexible)
    assert states is not None
    assert [len(part) for part in states] == [len(run.time) for run in prepared.fit]
    near = [screen(prepared, flexible, weights, effect_named(name), 0, None, given) for given in (None, states)]
    assert near[0].start == pytest.approx(near[1].start, rel=1e-4)
    assert near[0].promise == pytest.approx(near[1].promise, rel=1e-4)
    monkeypatch.setattr(cut_module, "observed", lambda balance, step, now, carried, moved: moved)
    monkeypatch.setattr(machine_module, "_kept", OrderedDict())  # those with an observer
    states = _states(prepared, flexible)
    trials = [screen(prepared, flexible, weights, effect_named(name), 0, None, given) for given in (None, states)]
    assert trials[0].start == pytest.approx(trials[1].start, rel=1e-9, abs=1e-12)
    assert trials[0].promise == pytest.approx(trials[1].promise, rel=1e-9, abs=1e-9)


def test_worth_beside_the_others(late: tuple[Prepared, Model, Weights]) -> None:
    """Of a true effect and a needless one, whichever was taken first: the one is worth all, the other nothing."""
    prepared, base, weights = late
    for names in (("delay", "cogging"), ("cogging", "delay")):
        models = [base]
        for name in names:
            placed = (*models[-1].placed, Placed(effect_named(name), 0))
            start = effect_named(name).starts(prepared.scales[0])[0]
            models.append(fit_model(prepared, placed, weights, models[-1].fit, start, evaluations=30))
        steps = [
            Step(before, (after,), rank(prepared, [before, after], FLOOR, 0), (1,), (), FLOOR)
            for before, after in pairwise(models)
        ]
        with Parallel(n_jobs=1) as pool:
            worth = weighed(prepared, steps, without_each(prepared, steps, pool), 0)
            found = {step.best.placed[-1].effect.name: step.worth for step in worth if step.best}
        late_one, needless = found["delay"], found["cogging"]
        assert late_one is not None
        assert needless is not None
        assert late_one.overall[1] > 0.8
        assert needless.overall[1] < 0.1


@pytest.mark.parametrize(("again", "kept"), [(3.0, "seen"), (0.5, "again"), (np.nan, "seen")])
def test_without_the_last_effect_the_model_that_the_search_saw_counts_where_a_fit_ends_elsewhere(
    late: tuple[Prepared, Model, Weights], again: float, kept: str
) -> None:
    prepared, base, _ = late

    def leaving(size: float, *names: str) -> Model:
        fit: Any = SimpleNamespace(residual=np.full((9, 1), size), at_limit=(), prior=0.0)
        return Model(tuple(Placed(effect_named(name), 0, {}) for name in names), fit, np.full((4, 1), size))

    first, both = leaving(1.0, "backlash"), leaving(0.1, "backlash", "cogging")
    gains: Any = SimpleNamespace(best=1)
    steps = [Step(base, (first,), gains, (1,), (), FLOOR), Step(first, (both,), gains, (1,), (), FLOOR)]
    refitted = {"again": leaving(again, "backlash"), "seen": first}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stribeck.gap.search.beside.weights_of", lambda *_: SimpleNamespace(scale=1.0))
        patch.setattr("stribeck.gap.search.beside.is_ordinary", lambda *_: False)
        without = without_each(prepared, steps, lambda _: [base, refitted["again"]])
    assert without[0] is base
    assert without[1] is refitted[kept]


def test_what_every_arm_has_does_not_grow_in_the_place_of_a_cause(late: tuple[Prepared, Model, Weights]) -> None:
    """Without the delay of 20 ms a lag of less than a millisecond would be one of 20: no word against the delay."""
    prepared, base, weights = late
    models, lag = [base], {"time_constant": 0.0005}
    for name, start, evaluations in (("delay", {"time": 0.02}, 30), ("actuator_lag", lag, 1)):
        placed = (*models[-1].placed, Placed(effect_named(name), 0))
        models.append(fit_model(prepared, placed, weights, models[-1].fit, start, evaluations=evaluations))
    assert models[-1].placed[1].values["time_constant"] < 0.0016
    steps = [
        Step(before, (after,), rank(prepared, [before, after], FLOOR, 0), (1,), (), FLOOR)
        for before, after in pairwise(models)
    ]
    with Parallel(n_jobs=1) as pool:
        without = without_each(prepared, steps, pool)
    assert [[place.effect.name for place in model.placed] for model in without] == [[], ["delay"]]
    assert rank(prepared, [without[0], models[-1]], FLOOR, 0).overall[1] > 0.8


def test_a_hopeless_start_is_not_followed(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch
) -> None:
    prepared, base, weights = late
    soft = {"stiffness": 0.3, "damping": 0.01}  # swings at half a hertz
    for at_most, followed in ((1e9, True), (1.0, False)):
        monkeypatch.setattr(screening, "HOPELESS", at_most)
        found = screen(prepared, base, weights, effect_named("joint_flexibility"), 0, soft)
        assert bool(np.isfinite(found.promise)) == followed


def taken(name: str, overall: float, t: float) -> Step:
    """A step that took an effect, with what its ranking, and its worth, say of it."""
    gains = SimpleNamespace(
        best=1, overall=np.array([0.0, overall]), t=np.array([0.0, t]), sure=np.array([0.0, 0.5]),
        power=np.array([[9.0], [9.0 * (1.0 - overall)]]), prior_gain=np.zeros(2),
    )  # fmt: skip
    model = SimpleNamespace(placed=(Placed(effect_named(name), 0),))
    return Step(SimpleNamespace(placed=()), (model,), gains, (1,), (), FLOOR, gains)  # type: ignore[arg-type]


@pytest.mark.parametrize(("overall", "t", "steps"), [(0.06, 2.9, 1), (0.95, 20.0, forward_module.MOST_STEPS)])
def test_the_search_ends_at_what_is_hardly_there(
    overall: float, t: float, steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(forward_module, "Tryout", lambda *_: None)
    monkeypatch.setattr(forward_module, "_step", lambda *given: taken("dwell_time", overall, t))
    setting = SimpleNamespace(prepared=SimpleNamespace(scales=(SCALE,)), floor=FLOOR, pool=None)
    assert len(forward_module.forward(setting, SimpleNamespace(placed=()), {})) == steps  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("t", "kept"), [((20.0, 20.0, 20.0), 5), ((0.4, 20.0, 0.4), 4), ((0.4, 0.4, 0.4), 3), ((0.4,), 4)]
)
def test_beyond_the_third_effect_only_what_is_likely_is_kept(
    t: tuple[float, ...], kept: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the last on; and what was given up has left no lower floor behind."""
    names = ("delay", "payload", "contact", "cogging", "backlash")
    monkeypatch.setattr(search_module, "weighed", lambda prepared, steps, *rest: steps)
    monkeypatch.setattr(search_module, "without_each", lambda *_: [])
    worth = [20.0] * (len(names) - len(t)) + list(t)
    steps = tuple(taken(name, 0.95 if own > 1.0 else 0.3, own) for name, own in zip(names, worth, strict=True))
    setting: Any = SimpleNamespace(prepared=None, pool=None, seed=0)
    ended = replace(steps[-1], passing=())
    for given in (steps, (*steps, ended)):
        found, _ = search_module._believed(setting, given)
        assert [step.taken for step in found[:kept]] == [True] * kept
        assert len(found) == (kept if kept < len(names) else len(given))


def test_it_ends_at_what_every_arm_has_and_goes_on_from_there_when_told(monkeypatch: pytest.MonkeyPatch) -> None:
    late = taken("delay", 0.95, 20.0)
    assert late.best is not None
    prompt = SimpleNamespace(placed=(replace(late.best.placed[0], values={"time": 0.001}),))
    step = replace(late, rivals=(prompt,))  # type: ignore[arg-type]
    monkeypatch.setattr(forward_module, "Tryout", lambda *_: None)
    monkeypatch.setattr(forward_module, "_step", lambda *given: step)
    monkeypatch.setattr(forward_module, "relawed", lambda *given: prompt)
    setting: Any = SimpleNamespace(prepared=SimpleNamespace(scales=(SCALE,)), floor=FLOOR, pool=None)
    base: Any = SimpleNamespace(placed=())
    steps = forward_module.forward(setting, base, {})
    assert len(steps) == 1
    assert len(forward_module.forward(setting, base, {}, steps)) == forward_module.MOST_STEPS


@pytest.mark.parametrize(
    ("names", "steps"),
    [
        (["presliding", "presliding", "backlash", "cogging", "delay", "contact", "payload", "history"], 7),
        (["presliding", "backlash", "cogging", "delay", "contact", "payload", "history"], 6),
        (["presliding"] * 10, 9),
    ],
)
def test_an_effect_at_further_joints_is_no_further_effect(
    names: list[str], steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every joint of an arm may have bristles: what else there is would not be looked for."""
    ahead = iter(names)
    monkeypatch.setattr(forward_module, "Tryout", lambda *_: None)
    monkeypatch.setattr(forward_module, "_step", lambda *given: taken(next(ahead), 0.95, 20.0))
    monkeypatch.setattr(forward_module, "relawed", lambda setting, floor, pool, model, *_: model)
    monkeypatch.setattr(forward_module, "ordinary", lambda *_: ())
    setting: Any = SimpleNamespace(prepared=SimpleNamespace(scales=(SCALE,)), floor=FLOOR, pool=None)
    assert len(forward_module.forward(setting, SimpleNamespace(placed=()), {})) == steps  # type: ignore[arg-type]


@pytest.mark.parametrize(("overall", "t", "kept"), [(0.06, 2.9, 1), (0.95, 20.0, 2)])
def test_nothing_is_weighed_beside_what_is_hardly_there(
    overall: float, t: float, kept: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second takes the first one's place as well as it can: together each is worth little."""
    weighings = []

    def weighing(prepared: object, steps: tuple[Step, ...], *rest: object) -> tuple[Step, ...]:
        weighings.append(sum(step.taken for step in steps))
        return steps

    monkeypatch.setattr(search_module, "weighed", weighing)
    monkeypatch.setattr(search_module, "without_each", lambda *_: [])
    setting: Any = SimpleNamespace(prepared=None, pool=None, seed=0)
    steps, _ = search_module._believed(setting, (taken("delay", 0.9, 12.0), taken("frictional_lag", overall, t)))
    assert [step.taken for step in steps] == [True] * kept + [False] * (2 - kept)
    assert weighings == [2, *([kept] if kept < 2 else [])]
    assert search_module._believed(setting, steps[:1])[0] == steps[:1]  # the only one stays, to be told


def test_an_effect_is_idle_that_is_worth_nothing_once_another_is_there() -> None:
    worthy, idle = taken("delay", 0.9, 12.0), taken("payload", 0.01, 0.5)
    assert idle_of([worthy, worthy]) is None
    assert idle_of([idle, worthy]) == Idle(("payload", 0), LEAST_GAIN)
    assert idle_of([worthy, idle]) is None  # the last has just been judged by the same figures
    assert idle_of([replace(idle, worth=None), worthy]) is None  # a fit that failed says nothing


def test_a_start_that_led_nowhere_is_not_the_next_one(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A law that another gap hid is tried from all of its starts again."""
    prepared, base, _ = late

    def hopeless(prepared: Prepared, base: Model, weights: Weights, effect: Effect, joint: int, *rest: object) -> Trial:
        return Trial(effect, joint, {}, -np.inf)

    monkeypatch.setattr(tryout_module, "screen", hopeless)
    monkeypatch.setattr(forward_module, "MUCH", np.inf)
    known: dict[tuple[str, str, int], dict[str, float]] = {}
    with Parallel(n_jobs=1) as pool:
        setting = Setting(prepared, FLOOR, 0, pool, (), frozenset(), lambda text: None)
        step = forward_module._step(setting, Tryout(setting, base, known), (), None)
    assert known == {}
    assert not step.taken
    assert len(step.screened_out) == len({(e.name, j) for e, j in candidates(prepared.arm, ())})


@pytest.mark.parametrize(("time", "kept"), [(0.001, True), (0.02, False)])
def test_what_grows_into_a_cause_beside_others_is_given_back(
    time: float, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A base re-tuned with what every arm has holds it only as long as it stays so small."""

    def with_delay(seconds: float) -> Any:
        late = taken("delay", 0.95, 20.0)
        assert late.best is not None
        model = SimpleNamespace(placed=(replace(late.best.placed[0], values={"time": seconds}),))
        return replace(late, rivals=(model,))  # type: ignore[arg-type]

    base: Any = SimpleNamespace(placed=())
    again = with_delay(0.001).best
    found = (with_delay(0.001),)
    grown = (replace(found[0], base=with_delay(time).best, passing=()),)
    went_on: list[object] = []

    def forward(
        setting: object, start: object, known: object, before: object = (), same: object = (), **_: object
    ) -> Any:
        went_on.append(before)
        return grown if start is again else found

    monkeypatch.setattr(search_module, "forward", forward)
    monkeypatch.setattr(search_module, "retuned_with", lambda *_: [again])
    monkeypatch.setattr(search_module, "referred", lambda prepared, _: prepared)
    prepared = SimpleNamespace(scales=(SCALE,), arm=SimpleNamespace(n=1))
    setting = Setting(prepared, FLOOR, 0, None, (), frozenset(), lambda _: None)  # type: ignore[arg-type]
    _, start, steps, _ = search_module._from_the_ordinary(setting, base)
    assert (start is again) is kept
    assert steps == (grown if kept else found)
    assert went_on[-1] == (() if kept else found)


def test_where_what_may_stand_beside_grows_the_next_base_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """What every arm has, taken in with others that grow, is taken in without them."""
    slight, large = ({"time": time} for time in (0.001, 0.02))
    late = effect_named("delay")
    small = SimpleNamespace(placed=(Placed(late, 0, slight),))
    both = SimpleNamespace(placed=(Placed(late, 0, slight), Placed(late, 1, slight)))
    grown = SimpleNamespace(placed=(Placed(late, 0, slight), Placed(late, 1, large)))
    found = (replace(taken("delay", 0.95, 20.0), base=SimpleNamespace(placed=()), rivals=(small,)),)  # type: ignore[arg-type]

    def forward(
        setting: object, start: object, known: object, before: object = (), same: object = (), **_: object
    ) -> Any:
        ends = {id(both): grown, id(small): small}.get(id(start))
        return found if ends is None else (replace(found[0], base=ends, passing=()),)

    monkeypatch.setattr(search_module, "forward", forward)
    monkeypatch.setattr(search_module, "retuned_with", lambda *_: iter([both, small]))
    monkeypatch.setattr(search_module, "referred", lambda prepared, _: prepared)
    monkeypatch.setattr(search_module, "ordinary", lambda steps, _: steps is found)
    prepared = SimpleNamespace(scales=(SCALE, SCALE), arm=SimpleNamespace(n=2))
    setting = Setting(prepared, FLOOR, 0, None, (), frozenset(), lambda _: None)  # type: ignore[arg-type]
    _, start, _, _ = search_module._from_the_ordinary(setting, SimpleNamespace(placed=()))  # type: ignore[arg-type]
    assert start is small


def test_a_search_made_anew_has_the_same_rivals_as_long_as_it_comes_to_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A step among them that comes to something else, or to nothing, is made again with all candidates."""
    earlier = [taken(name, 0.95, 20.0) for name in ("delay", "backlash", "cable_spring")]
    nothing = replace(earlier[1], passing=())
    asked: list[object] = []
    others = iter(("payload", "contact"))

    def step(*given: object) -> Step:
        same = given[4] if len(given) > 4 else None
        asked.append(same)
        return {id(earlier[0]): earlier[0], id(earlier[1]): nothing}.get(id(same)) or taken(next(others), 0.95, 20.0)

    monkeypatch.setattr(forward_module, "MOST_EFFECTS", 3)
    monkeypatch.setattr(forward_module, "Tryout", lambda *_: None)
    monkeypatch.setattr(forward_module, "_step", step)
    monkeypatch.setattr(forward_module, "relawed", lambda setting, floor, pool, model, *_: model)
    monkeypatch.setattr(forward_module, "ordinary", lambda *_: ())
    setting: Any = SimpleNamespace(prepared=SimpleNamespace(scales=(SCALE,)), floor=FLOOR, pool=None)
    steps = forward_module.forward(setting, SimpleNamespace(placed=()), {}, same=earlier)  # type: ignore[arg-type]
    assert asked == [earlier[0], earlier[1], None, None]
    assert [step.best and step.best.placed[-1].effect.name for step in steps] == ["delay", "payload", "contact"]


def test_a_search_made_anew_is_told_the_steps_before_what_every_arm_has(monkeypatch: pytest.MonkeyPatch) -> None:
    large, slight = Placed(effect_named("payload"), 0), Placed(effect_named("delay"), 0, {"time": 0.001})
    first = replace(taken("payload", 0.9, 12.0), rivals=(SimpleNamespace(placed=(large,)),))  # type: ignore[arg-type]
    second = replace(first, rivals=(SimpleNamespace(placed=(large, slight)),))  # type: ignore[arg-type]
    again: Any = SimpleNamespace(placed=(slight,))
    told: list[object] = []

    def forward(setting: object, base: object, known: object, same: object = (), **_: object) -> Any:
        told.append(same)
        return (replace(first, base=again, passing=()),) if base is again else (first, second)

    monkeypatch.setattr(search_module, "forward", forward)
    monkeypatch.setattr(search_module, "retuned_with", lambda *_: [again])
    monkeypatch.setattr(search_module, "referred", lambda prepared, _: prepared)
    prepared: Any = SimpleNamespace(scales=(SCALE,))
    setting = Setting(prepared, FLOOR, 0, None, (), frozenset(), lambda _: None)
    search_module._from_the_ordinary(setting, SimpleNamespace(placed=()))  # type: ignore[arg-type]
    assert told == [(), [first]]


def test_what_every_arm_was_re_tuned_with_is_a_candidate_once_it_has_grown(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing that the base holds is one: a lateness that another effect had hidden would go by no name."""
    stated, late = Placed(effect_named("payload"), 0, {"mass": 1.0}), effect_named("delay")
    base: Any = SimpleNamespace(placed=(stated, Placed(late, 0, {"time": 0.001})))
    grown = SimpleNamespace(placed=(stated, Placed(late, 0, {"time": 0.01}), Placed(effect_named("backlash"), 0)))
    bare = SimpleNamespace(placed=(stated,))
    starts: list[object] = []

    def forward(setting: object, start: object, *_: object, **__: object) -> Any:
        starts.append(start)
        ends = grown if start is base else start
        return (replace(taken("backlash", 0.9, 12.0), base=ends, passing=()),)

    monkeypatch.setattr(search_module, "forward", forward)
    monkeypatch.setattr(search_module, "retune", lambda prepared, floor, placed: bare if placed == [stated] else None)
    monkeypatch.setattr(search_module, "referred", lambda prepared, _: prepared)
    monkeypatch.setattr(search_module, "ordinary", lambda *_: ())
    prepared: Any = SimpleNamespace(scales=(SCALE,))
    setting = Setting(prepared, FLOOR, 0, None, (), frozenset(), lambda _: None, stated=1)
    _, start, _, _ = search_module._from_the_ordinary(setting, base)
    assert starts == [base, bare]
    assert start is bare


def test_the_rivals_of_an_earlier_step_are_fitted_from_where_they_ended(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is screened for them but the other laws of the best one, and none of them starts anywhere else."""
    prepared, base, _ = late
    screened: list[str] = []
    starts: list[Trial] = []
    fit_trial = tryout_module._fit_trial

    def screen_one(prepared: object, base: object, weights: object, effect: Effect, *_: object) -> Trial:
        screened.append(effect.name)
        return Trial(effect, 0, {"time": 0.02}, 9.0 if effect.name == "delay" else -np.inf)

    def fit_one(prepared: Prepared, base: Model, weights: Weights, trial: Trial, floor: np.ndarray) -> Any:
        starts.append(trial)
        return fit_trial(prepared, base, weights, trial, floor)

    monkeypatch.setattr(tryout_module, "screen", screen_one)
    monkeypatch.setattr(tryout_module, "_fit_trial", fit_one)
    with Parallel(n_jobs=1) as pool:
        setting = Setting(prepared, FLOOR, 0, pool, (), frozenset(), lambda text: None)
        same = forward_module._step(setting, Tryout(setting, base, {}), (), None)
        assert same.best is not None
        screened.clear()
        starts.clear()
        tryout = Tryout(setting, base, {})
        step = forward_module._step(setting, tryout, (), None, same)
        assert screened == []
        assert [(trial.start, trial.fitted) for trial in starts] == [(same.best.placed[-1].values, True)]
        assert step.screened_out == same.screened_out
        forward_module._step(setting, tryout, (), None)
    assert len(screened) == len(candidates(prepared.arm, ()))
    assert len(starts) == 1, "what was fitted is not fitted again"


def test_what_was_taken_comes_first_again_and_not_what_the_base_has_by_now(
    late: tuple[Prepared, Model, Weights],
) -> None:
    """The best by score had not passed; another rival is by now what every arm has, a second bristle on one joint."""
    prepared, _, weights = late
    bristles = Placed(effect_named("presliding"), 0)
    names = ("torque_offset", "presliding", "delay")
    rivals = [fit_model(prepared, (Placed(effect_named(name), 0),), weights) for name in names]
    ranking: Any = SimpleNamespace(best=3, order=(1, 2, 3))
    same = replace(taken("delay", 0.9, 12.0), rivals=tuple(rivals), ranking=ranking)
    base = fit_model(prepared, (bristles,), weights)
    tryout = Tryout(Setting(prepared, FLOOR, 0, None, (), frozenset(), lambda text: None), base, {})
    assert [trial.effect.name for trial in forward_module._as_before(same, tryout)] == ["delay", "torque_offset"]


def test_a_base_that_runs_away_when_it_is_fitted_anew_stays_as_it_was(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stand that slides and turns far had no numbers left where it was judged, and a diagnosis ended there."""
    prepared, base, _ = late

    def astray(*given: Any) -> Model:
        return replace(base, held=np.full_like(base.held, np.nan))

    setting = Setting(prepared, FLOOR, 0, None, (), frozenset(), lambda text: None)
    assert Tryout(setting, base, {}).base is not base
    monkeypatch.setattr(tryout_module, "fit_model", astray)
    assert Tryout(setting, base, {}).base is base


def test_other_laws_of_an_earlier_best_are_tried(late: tuple[Prepared, Model, Weights]) -> None:
    prepared, base, _ = late
    tryout = Tryout(Setting(prepared, FLOOR, 0, None, (), frozenset(), lambda text: None), base, {})
    names = {effect.law for effect, _ in tryout.possible if effect.name == "presliding"}
    effect = effect_named("presliding")
    others = forward_module._other_laws(Trial(effect, 0, {}), tryout)
    assert others == {("presliding", law, 0) for law in names - {effect.law}}
    assert others


def test_what_stands_beside_for_nothing_is_no_part_of_a_base(late: tuple[Prepared, Model, Weights]) -> None:
    prepared, _, weights = late
    delay, offset = Placed(effect_named("delay"), 0, {"time": 0.02}), Placed(effect_named("torque_offset"), 0)
    model = fit_model(prepared, (offset, delay), weights)
    kept = [_needed_of(prepared, FLOOR, model, first, 0).placed for first in (0, 1)]
    assert [[place.effect.name for place in placed] for placed in kept] == [["delay"], ["torque_offset", "delay"]]


def test_a_start_that_is_about_to_save_nothing_is_looked_at_only(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch
) -> None:
    prepared, base, weights = late
    followed: list[bool] = []
    go = Descent.go

    def looking(way: Descent, steps: int) -> None:
        followed.append(steps == screening.STEPS)
        go(way, steps)

    monkeypatch.setattr(Descent, "go", looking)
    ends = {}
    for worth in (0.0, screening.WORTH, 2.0):
        monkeypatch.setattr(screening, "WORTH", worth)
        for name in ("torque_offset", "delay"):
            followed.clear()
            ends[name, worth] = screen(prepared, base, weights, effect_named(name), 0), any(followed)
    assert [ends[key][1] for key in ends] == [True, True, False, True, False, False]
    assert all(np.isfinite(trial.promise) for trial, _ in ends.values())  # as far as it was looked at


def test_beside_a_play_what_does_not_show_at_once_is_not_looked_for(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each look takes long there."""
    prepared, base, weights = late
    followed: list[int] = []
    monkeypatch.setattr(Descent, "go", lambda way, steps: setattr(way, "ahead", 0.0) or followed.append(steps))
    play = Placed(effect_named("backlash"), 0, effect_named("backlash").starts(prepared.scales[0])[0])
    for placed, looks in (((), {screening.LOOK, screening.STEPS}), ((play,), {screening.LOOK})):
        followed.clear()
        screen(prepared, replace(base, placed=placed), weights, effect_named("presliding"), 0)
        assert set(followed) == looks


def bare_setting(prepared: Any) -> Any:
    """A setting of which nothing is used but what is asked for by name."""
    barred: frozenset[tuple[str, int]] = frozenset()
    return SimpleNamespace(
        prepared=prepared, seed=0, pool=None, leave_out=(), barred=barred, progress=lambda text: None
    )


def test_the_search_without_what_is_needless_starts_from_what_every_arm_has_as_well(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It would end at the first such effect that it finds, with a cause still hidden behind it."""
    barred: list[frozenset[tuple[str, int]]] = []

    def from_the_ordinary(setting: Any, base: object, **_: object) -> Any:
        barred.append(setting.barred)
        retuned = SimpleNamespace(rounds=len(barred))
        return replace(setting, prepared=retuned), base, (taken("delay", 0.9, 12.0),), ()

    monkeypatch.setattr(search_module, "referred", lambda prepared, _: prepared)
    monkeypatch.setattr(search_module, "_from_the_ordinary", from_the_ordinary)
    monkeypatch.setattr(search_module, "_believed", lambda setting, steps: (steps, []))
    monkeypatch.setattr(search_module, "another_way", lambda setting, base, steps: steps)
    # what comes in its place may be needless in turn
    needless = iter((Idle(("cogging", 0), LEAST_GAIN), Idle(("payload", 0), LEAST_GAIN), None))
    monkeypatch.setattr(search_module, "idle", lambda steps: next(needless))
    monkeypatch.setattr(search_module, "instead", lambda *_: [])
    monkeypatch.setattr(search_module, "rank", lambda *_: SimpleNamespace(overall=[0.0, 0.0]))
    monkeypatch.setattr(search_module, "with_look_alikes", lambda prepared, steps, *_: steps)
    monkeypatch.setattr(search_module, "in_lower_band", lambda *_: None)
    given: Any = SimpleNamespace(arm=NOMINAL), np.zeros((1, 1)), SimpleNamespace(rms=FLOOR), SimpleNamespace()
    monkeypatch.setattr(search_module, "of_asked_lengths", lambda *_: None)
    tuned, _ = search_module.search(Retuned(*given), Asked(jobs=1))
    assert barred == [frozenset(), frozenset({("cogging", 0)}), frozenset({("cogging", 0), ("payload", 0)})]
    assert tuned.prepared.rounds == 3  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("anew", "after", "taken_at_once"), [(-0.5, 0.0, True), (0.0, 0.0, False), (-0.5, -0.5, False)]
)
def test_where_a_search_anew_leaves_more_what_came_after_the_needless_one_is_taken(
    anew: float, after: float, taken_at_once: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only where that is as good as with the needless one."""
    first, other, at_once = ((taken(name, 0.9, 12.0),) for name in ("delay", "payload", "cogging"))
    searches, gains = iter((first, other)), iter((anew, after))
    base: Any = SimpleNamespace(placed=())

    def from_the_ordinary(setting: Any, start: object, **_: object) -> Any:
        return setting, base, next(searches), ()

    monkeypatch.setattr(search_module, "_setting", lambda *_: bare_setting("prepared"))
    monkeypatch.setattr(search_module, "replace", lambda given, **_: given)
    monkeypatch.setattr(search_module, "_from_the_ordinary", from_the_ordinary)
    monkeypatch.setattr(search_module, "in_lower_band", lambda *_: None)
    monkeypatch.setattr(search_module, "in_step_beside", lambda prepared, _: prepared)
    monkeypatch.setattr(search_module, "_believed", lambda setting, steps: (steps, []))
    monkeypatch.setattr(search_module, "passed_over", lambda *_: at_once)
    monkeypatch.setattr(search_module, "rank", lambda *_: SimpleNamespace(overall=[0.0, next(gains)]))
    needless = iter((Idle(("cogging", 0), LEAST_GAIN), None))
    monkeypatch.setattr(search_module, "idle", lambda steps: next(needless))
    for name in ("another_way", "with_as_good", "with_lags", "with_together", "with_look_alikes"):
        monkeypatch.setattr(search_module, name, lambda *given: next(one for one in given if isinstance(one, tuple)))
    for name in ("instead", "swapped"):
        monkeypatch.setattr(search_module, name, lambda *_: [])
    tuned: Any = SimpleNamespace(prepared="prepared", base=base)
    wanted = at_once if taken_at_once else first if anew < 0.0 else other
    monkeypatch.setattr(search_module, "of_asked_lengths", lambda *_: None)
    assert search_module.search(tuned, Asked(jobs=1))[1] == wanted


@pytest.mark.long
def test_what_promised_as_much_as_what_is_taken_is_fitted_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few are fitted; of those left out one may be the same in disguise as the one that is taken."""
    for limit in ("LEAST_SURVIVORS", "LEAST_AT_JOINT", "MOST_SURVIVORS"):
        monkeypatch.setattr(forward_module, limit, 1)
    few = tuple(name for name in registry() if name not in ("delay", "actuator_lag", "payload"))
    found = diagnose(NOMINAL, recorded(("delay", {"time": 0.02})), jobs=1, leave_out=few)
    fitted = {row.effect for row in found.candidates if np.isfinite(row.t) and row.step == 1}
    assert fitted >= {"delay", "actuator_lag"}


def test_by_a_lower_band_what_was_re_tuned_along_is_looked_for_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is in no later step: told the rivals of these, the new search would go on as if it were not there."""
    first, last = taken("encoder_offset", 0.9, 12.0), taken("presliding", 0.9, 12.0)
    bands = iter((SimpleNamespace(prepared="lower", base=SimpleNamespace(placed=())), None))
    told: list[Sequence[Step]] = []

    def from_the_ordinary(setting: Any, base: object, same: Sequence[Step] = (), **_: object) -> Any:
        told.append(same)
        return setting, SimpleNamespace(placed=()), (last,), (first, replace(last, passing=()))

    monkeypatch.setattr(search_module, "_setting", lambda tuned, *_: bare_setting(tuned.prepared))
    monkeypatch.setattr(search_module, "_from_the_ordinary", from_the_ordinary)
    monkeypatch.setattr(search_module, "replace", lambda tuned, **_: tuned)
    monkeypatch.setattr(search_module, "in_lower_band", lambda *_: next(bands))
    monkeypatch.setattr(search_module, "in_step_beside", lambda prepared, _: prepared)
    monkeypatch.setattr(search_module, "_believed", lambda setting, steps: (steps, []))
    for name in ("another_way", "with_as_good", "with_lags", "with_together", "with_look_alikes"):
        monkeypatch.setattr(search_module, name, lambda *given: given[2] if given[2] == (last,) else given[1])
    for name in ("instead", "swapped"):
        monkeypatch.setattr(search_module, name, lambda *_: [])
    for name in ("idle", "outdone", "misleading"):
        monkeypatch.setattr(search_module, name, lambda *_: None)
    tuned: Any = SimpleNamespace(prepared="first", base=SimpleNamespace(placed=()))
    monkeypatch.setattr(search_module, "of_asked_lengths", lambda *_: None)
    assert search_module.search(tuned, Asked(jobs=1))[1] == (last,)
    assert told == [(), [first]]


def test_links_of_other_lengths_that_do_what_an_effect_does_start_the_search_anew(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Told the models without each effect, and by the last floor."""
    last = taken("gravity_tilt", 0.9, 12.0)
    asked_with: list[object] = []

    def lengths(tuned: Any, models: object, floor: object, _: object) -> Any:
        asked_with.append((models, floor))
        return SimpleNamespace(prepared="longer") if tuned.prepared == "first" else None

    def by_the_band(tuned: Any, *_: object) -> Any:
        return tuned, bare_setting(tuned.prepared), None, (replace(last, floor=tuned.prepared),)

    monkeypatch.setattr(search_module, "_forward_by_the_band", by_the_band)
    monkeypatch.setattr(search_module, "replace", lambda tuned, **_: tuned)
    monkeypatch.setattr(search_module, "_believed", lambda setting, steps: (steps, ["without it"]))
    monkeypatch.setattr(search_module, "another_way", lambda setting, base, steps: steps)
    monkeypatch.setattr(search_module, "_without_the_needless", lambda setting, _, steps, without: (
        setting, steps, without, []
    ))  # fmt: skip
    for name in ("with_as_good", "with_lags", "with_together", "with_look_alikes"):
        monkeypatch.setattr(search_module, name, lambda *given: given[1] if isinstance(given[1], tuple) else given[0])
    monkeypatch.setattr(search_module, "of_asked_lengths", lengths)
    tuned: Any = SimpleNamespace(prepared="first")
    again, steps = search_module.search(tuned, Asked(jobs=1))
    assert (again.prepared, steps[0].floor) == ("longer", "longer")
    assert asked_with == [(["without it"], "first"), (["without it"], "longer")]


def test_only_the_search_for_the_band_ends_where_a_lower_one_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Made again for another reason it goes on to its end, whatever band its models would ask for."""
    told: list[bool] = []

    def forward(setting: object, start: object, known: object, *_: object, until: Any, **__: object) -> Any:
        told.append(until(start))
        return (taken("backlash", 0.9, 12.0),)

    monkeypatch.setattr(search_module, "forward", forward)
    monkeypatch.setattr(search_module, "ordinary", lambda *_: False)
    setting = SimpleNamespace(prepared=SimpleNamespace(scales=()), stated=0)
    base: Any = SimpleNamespace(placed=())
    for asked in ({}, {"until": lambda *_: True}):
        search_module._from_the_ordinary(setting, base, **asked)  # type: ignore[arg-type]
    assert told == [False, True]


def test_what_promised_far_more_or_less_is_not_the_same_in_disguise(late: tuple[Prepared, Model, Weights]) -> None:
    _, base, _ = late
    taken = Placed(registry()["delay"], 0, {"time": 0.02})
    judged = Judged([replace(base, placed=(taken,))], SimpleNamespace(best=1), (1,), FLOOR)  # type: ignore[arg-type]
    others = zip(("payload", "cogging", "contact", "history"), (0.9, 0.96, 1.04, 1.2), strict=True)
    tried = [Trial(taken.effect, 0, {}, 1.0), *(Trial(registry()[name], 0, {}, promise) for name, promise in others)]
    assert [trial.effect.name for trial in as_hopeful(tried, {taken.key}, judged)] == ["cogging", "contact"]
    assert as_hopeful(tried, {taken.key}, judged._replace(passing=())) == []


@pytest.mark.parametrize(
    ("gain", "first", "last", "found"),
    [
        (0.997, 0.45, 0.52, True),  # a cable; what is left of it a wave takes, and most of the cable's as well
        (0.997, 0.97, 0.52, False),  # a cable, and a wave that is no cable
        (0.6, 0.05, 0.95, False),  # a cable that followed the wave in part: needless, and the wave is there
        (0.6, 0.55, 0.1, False),  # next to nothing beside what is there
    ],
)
def test_of_two_that_do_the_same_work_the_first_is_believed(
    gain: float, first: float, last: float, found: bool
) -> None:
    def step(own: float, worth: float) -> Any:
        ranking, beside = (SimpleNamespace(best=1, overall=np.array([0.0, part])) for part in (own, worth))
        return SimpleNamespace(ranking=ranking, worth=beside)

    assert stands_in((step(gain, first), step(last, last))) is found
    assert not stands_in((step(gain, first),))


def test_a_compliance_that_took_little_is_not_sought_again_beside_as_much(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fits from every start are half of a long search; what was left at the joint tells whether they are needed."""
    prepared = prepare(TRUE, recorded())
    base = retune(prepared, FLOOR)
    sought: list[tuple[str, int]] = []

    def nothing(prepared: Prepared, base: Model, weights: Weights, wanted: Any, pool: object) -> list[None]:
        sought.extend((effect.name, joint) for effect, joint in wanted)
        return [None] * len(wanted)

    monkeypatch.setattr(tryout_module, "from_every_start", nothing)
    with Parallel(n_jobs=1) as pool:
        setting = Setting(prepared, FLOOR, 0, pool, (), frozenset(), lambda text: None)
        for part, anew in ((1.0, True), (0.95, False), (0.5, True), (1.05, False), (2.0, True)):
            tryout = Tryout(setting, base, {})
            tryout.base = SimpleNamespace(whole=part * base.whole)  # type: ignore[assignment]
            assert tryout.sought([0]) == []
            assert bool(sought) is anew, part
            assert {"backlash", "joint_flexibility"} <= {name for name, _ in sought} or not anew
            sought.clear()


def test_what_was_taken_at_several_joints_is_weighed_as_a_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Against a model without it at any of them; what every arm has is no cause, and stays."""

    def place(name: str, joint: int, **values: float) -> Placed:
        return Placed(effect_named(name), joint, values)

    own = place("cable_spring", 0, stiffness=3.0, rest=0.0)
    soft = [place("joint_flexibility", j, stiffness=60.0, damping=0.8) for j in (0, 1)]
    late = [place("delay", j, time=time) for j, time in ((0, 0.02), (1, 1e-4))]
    placed = (own, *soft, *late)
    asked: list[tuple[Placed, ...]] = []

    def fitted(prepared: object, placed: Any, *_: object, **named: object) -> Any:
        asked.append(tuple(placed))
        return SimpleNamespace(placed=tuple(placed))

    monkeypatch.setattr(beside_module, "fit_model", fitted)
    monkeypatch.setattr(beside_module, "weights_of", lambda *_: None)
    monkeypatch.setattr(beside_module, "finite", lambda model: True)
    monkeypatch.setattr(beside_module, "rank", lambda prepared, models, *_: len(models[0].placed))
    models: list[Any] = [SimpleNamespace(placed=placed[: k + 1]) for k in range(5)]
    ranking: Any = SimpleNamespace(best=1)
    steps = [Step(before, (best,), ranking, (1,), (), FLOOR) for before, best in pairwise(models)]
    prepared: Any = SimpleNamespace(scales=(Scale(1.0, 1.0, 1.0, 1.0, 1.0, 1e-3),) * 2)
    found = with_together(prepared, steps, Parallel(n_jobs=1), 0)
    assert asked == [(own, *late), (own, *soft, late[1])]
    assert [step.together for step in found] == [3, 3, 4, 4]
    assert with_together(prepared, steps[:1], None, 0) == tuple(steps[:1])


@pytest.mark.parametrize(("cost", "taken"), [(9.0, True), (70.0, False), (np.nan, False)])
def test_a_play_is_fitted_once_more_with_its_blows_all_but_undamped(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch, cost: float, taken: bool
) -> None:
    prepared, base, weights = late
    play = effect_named("backlash")
    start = {"gap": 0.01, "stiffness": 700.0, "damping": 20.0}

    def fit_once(prepared: Prepared, placed: Any, weights: Weights, known: Any, start: Any, **_: Any) -> Any:
        again = start["damping"] < 1.0
        residual = np.full((3, 1), np.inf if again and np.isnan(cost) else 1.0)
        fit: Any = SimpleNamespace(cost=cost if again else 50.0, ok=True, residual=residual)
        return Model((Placed(play, 0, start),), fit, residual)

    monkeypatch.setattr(tryout_module, "fit_model", fit_once)
    monkeypatch.setattr(tryout_module, "weights_of", lambda *_: weights)
    fitted = _fit_trial(prepared, base, weights, Trial(play, 0, start, 1.0), FLOOR)
    assert fitted is not None
    damping = tryout_module.LEAST_DAMPED * 20.0 if taken else 20.0
    assert fitted.model.placed[0].values == {"gap": 0.01, "stiffness": 700.0, "damping": pytest.approx(damping)}


@pytest.mark.parametrize(
    ("left", "cost", "gap"),
    [(1.0, 9.0, 0.0147), (1.0, 60.0, 0.01), (1e-3, 9.0, 0.01), (1.0, np.nan, 0.01)],
    ids=["another valley", "none that is deeper", "next to nothing is left", "it runs away there"],
)
def test_a_play_that_leaves_much_is_fitted_from_wider_and_narrower_ones(
    late: tuple[Prepared, Model, Weights], monkeypatch: pytest.MonkeyPatch, left: float, cost: float, gap: float
) -> None:
    prepared, base, weights = late
    play, tried = effect_named("backlash"), []
    start = {"gap": 0.01, "stiffness": 700.0, "damping": 20.0}

    def fit_once(prepared: Prepared, placed: Any, weights: Weights, known: Any, start: Any, **_: Any) -> Any:
        tried.append(start["gap"])
        wide = start["gap"] > 0.012
        residual = np.full((3, 1), np.inf if wide and np.isnan(cost) else left)
        fit: Any = SimpleNamespace(cost=cost if wide else 50.0, ok=True, residual=residual)
        return Model((Placed(play, 0, start),), fit, residual)

    monkeypatch.setattr(tryout_module, "fit_model", fit_once)
    monkeypatch.setattr(tryout_module, "weights_of", lambda *_: weights)
    fitted = _fit_trial(prepared, base, weights, Trial(play, 0, start, 1.0), FLOOR)
    assert base.fit.cost > 50.0 / tryout_module.NEAR
    assert fitted is not None
    assert fitted.model.placed[0].values["gap"] == pytest.approx(gap)
    assert (min(tried), max(tried)) == pytest.approx((0.0068, 0.0147) if left > 0.1 else (0.01, 0.01))
