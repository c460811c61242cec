"""What every arm has some of is re-tuned and told of, wherever a search finds it; more of the same is named."""

import io
import math
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from stribeck.effects.registry import effect_named, laws, registry
from stribeck.gap.diagnose import diagnose
from stribeck.gap.fitted.model import Model, fit_model, retune, weights_of
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search import ordinary as ordinary_module
from stribeck.gap.search import search as search_module
from stribeck.gap.search.ordinary import _needed_of, retuned_with, told_unnamed
from stribeck.gap.search.rank import rank
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.step import Step
from stribeck.gap.search.tuned import retuned
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale
from stribeck.report.summary import summary

from ..conftest import FRICTION, NOMINAL, recorded, taken_steps

SCALE = Scale(10.0, 4.0, 1.0, 1.0, 1.0, 1e-3)  # 4 N m of Coulomb friction
FLOOR = np.array([0.02])
TRIED = ("presliding", "position_dependent_friction", "load_dependent_friction", "torque_ripple", "cogging", "delay")
OTHERS = tuple(name for name in registry() if name not in TRIED)
BRISTLES = [effect for effect in laws().values() if effect.name == "presliding"]


@pytest.mark.parametrize("effect", BRISTLES, ids=lambda effect: effect.law)
def test_a_contact_that_gives_way_by_no_more_than_any_does_is_ordinary(effect: Effect) -> None:
    def ordinary(gives: float, scale: Scale = SCALE) -> bool:
        return effect.ordinary({"stiffness": 4.0 / gives, "damping": 0.0}, scale)

    assert ordinary(1.5e-4)
    assert not ordinary(2.5e-4)
    on_an_axis = replace(SCALE, prismatic=True)
    assert ordinary(8e-6, on_an_axis)
    assert not ordinary(1.5e-5, on_an_axis)
    assert not ordinary(1.5e-4, replace(SCALE, friction=0.0))  # the arm file says nothing of it


@pytest.mark.parametrize(
    ("middle", "covered", "ordinary"),
    [(0.0, 2.0, True), (math.pi, 2.0, False), (0.0, 2.0 * math.pi, False)],
    ids=["where they cancel", "where they do not", "a whole turn"],
)
def test_friction_is_uneven_by_as_much_as_it_varies_along_the_way(
    middle: float, covered: float, ordinary: bool
) -> None:
    """Slow waves may all but cancel each other where the joint goes."""
    waves = {"cosine": 0.4, "second_cosine": -0.14, "third_cosine": 0.03, "harmonic": 1.0}
    values = {p.name: 0.0 for p in laws()["position_dependent_friction", "harmonics"].parameters} | waves
    scale = replace(SCALE, middle=middle, covered=covered)
    assert laws()["position_dependent_friction", "harmonics"].ordinary(values, scale) is ordinary


@pytest.mark.parametrize(
    ("name", "law", "little"),
    [
        ("torque_offset", None, {"offset": -0.14}),
        ("encoder_offset", None, {"offset": 0.019}),
        ("encoder_eccentricity", "one_wave", {"sine": 1.2e-4, "cosine": -1.2e-4, "harmonic": 33.0}),
        (
            "encoder_eccentricity",
            "two_waves",
            {"sine": 0.0, "cosine": 1.2e-4, "second_sine": 0.0, "second_cosine": -1.2e-4, "harmonic": 1.0},
        ),
        ("cogging", "one_wave", {"sine": 0.1, "cosine": -0.1, "harmonic": 12.0}),
        (
            "cogging",
            "two_waves",
            {"sine": 0.1, "cosine": 0.0, "second_sine": 0.0, "second_cosine": -0.1, "harmonic": 9.0},
        ),
        ("torque_ripple", "one_wave", {"sine": 0.01, "cosine": -0.01, "harmonic": 6.0}),
        (
            "torque_ripple",
            "two_waves",
            {"sine": 0.0, "cosine": 0.01, "second_sine": 0.01, "second_cosine": 0.0, "harmonic": 6.0},
        ),
        ("asymmetric_friction", None, {"coulomb": -0.1, "viscous": 0.09}),  # of 4 N m
        ("gravity_tilt", None, {"x": 0.04, "y": -0.02}),
        ("cable_spring", "linear", {"stiffness": 0.15, "rest": 0.3}),
        ("cable_spring", "hardening", {"stiffness": 0.06, "rest": 0.4, "cubic": 0.1}),
        ("position_dependent_friction", None, {"sine": -0.027, "cosine": 0.027, "harmonic": 3.0}),
    ],
)
def test_what_strays_by_a_per_cent_is_ordinary(name: str, law: str | None, little: dict[str, float]) -> None:
    effect, scale = effect_named(name, law), replace(SCALE, covered=2.0 * math.pi)
    assert effect.ordinary(little, scale)
    for part in set(little) - {"harmonic"}:
        if little[part]:
            assert not effect.ordinary(little | {part: 2.0 * little[part]}, scale)


@pytest.mark.parametrize("law", ["one_wave", "two_waves"])
@pytest.mark.parametrize(("name", "unit"), [("cogging", SCALE.torque), ("torque_ripple", 1.0)])
def test_a_drive_s_waves_that_are_plain_to_see_are_not(name: str, unit: float, law: str) -> None:
    """A per cent of the torque: three noise floors, root mean square."""
    waves = {"sine": 0.006 * unit, "cosine": -0.008 * unit, "second_sine": 0.0, "second_cosine": 0.0, "harmonic": 9.0}
    rms = 0.01 * SCALE.torque / math.sqrt(2.0)
    for part, expected in ((0.34, True), (0.32, False)):
        assert effect_named(name, law).ordinary(waves, replace(SCALE, noise=part * rms)) == expected


def test_what_is_plain_to_see_goes_by_the_noise_of_the_recordings() -> None:
    prepared = prepare(NOMINAL, recorded(noise=1e-6))
    tuned = retuned(prepared, Asked(0, 1, (), lambda text: None))
    assert [scale.noise for scale in prepared.scales] == [math.inf]
    assert [scale.noise for scale in tuned.prepared.scales] == list(tuned.noise.rms)


@pytest.mark.parametrize("law", ["one_pole", "delay", "falling_part", "whole_curve"])
def test_friction_that_trails_by_two_samples_is_ordinary(law: str) -> None:
    effect = effect_named("frictional_lag", law)
    assert effect.ordinary({"time": 1.9 * SCALE.sample_time}, SCALE)
    assert not effect.ordinary({"time": 2.1 * SCALE.sample_time}, SCALE)


def test_a_motor_that_loses_two_per_cent_when_it_pulls_twice_as_hard_is_ordinary() -> None:
    effect = effect_named("torque_saturation", "smooth")
    for limit, expected in ((np.inf, True), (85.0, True), (75.0, False), (30.0, False)):  # 0, 1.8, 2.3 and 12 %
        assert effect.ordinary({"limit": limit}, SCALE) == expected
    assert not effect_named("torque_saturation", "constant").ordinary({"limit": 100.0}, SCALE)


TEXTURE = ("position_dependent_friction", {"amplitude": 0.015 * FRICTION.C0, "harmonic": 3.0})


@pytest.mark.long
@pytest.mark.parametrize(("lost", "named"), [(0.012, ()), (0.05, ("torque_saturation",))])
def test_iron_that_takes_a_per_cent_is_no_cause(lost: float, named: tuple[str, ...]) -> None:
    """Of 14.3 N m, twice the typical torque; the plant's law is another one, (u / limit)^2.4 / 2.4 at first."""
    iron = ("torque_saturation", {"limit": 14.3 / (2.4 * lost) ** (1.0 / 2.4), "sharp": 2.4})
    others = tuple(name for name in registry() if name not in {"torque_saturation", "torque_gain", "delay"})
    found = diagnose(NOMINAL, recorded(iron, noise=1e-6), jobs=1, leave_out=others)
    assert (found.verdict, found.named) == ("explained" if named else "no_gap", named)
    assert any("torque_saturation" in note for note in found.notes) == (not named)


@pytest.mark.slow
def test_what_is_hidden_beside_a_texture_of_friction_is_named() -> None:
    beside = diagnose(NOMINAL, recorded(TEXTURE, ("delay", {"time": 0.02}), noise=1e-6), jobs=1)
    assert beside.named == ("delay",)


@pytest.mark.slow
def test_a_texture_of_friction_is_no_cause() -> None:
    slight = diagnose(NOMINAL, recorded(TEXTURE, noise=1e-6), jobs=1, leave_out=OTHERS)
    assert (slight.verdict, slight.named) == ("no_gap", ())
    assert any("position_dependent_friction" in note for note in slight.notes)


@pytest.mark.long
@pytest.mark.parametrize(("gives", "named"), [(1e-4, ()), pytest.param(3e-3, ("presliding",), marks=pytest.mark.slow)])
def test_where_a_search_finds_it_the_model_is_retuned_with_it(gives: float, named: tuple[str, ...]) -> None:
    hidden = ("presliding", {"stiffness": FRICTION.C0 / gives, "damping": 1.0})
    found = diagnose(NOMINAL, recorded(hidden, noise=1e-6), jobs=1, leave_out=OTHERS)
    assert found.named == named
    assert found.verdict == ("explained" if named else "no_gap")
    told = [note for note in found.notes if "presliding" in note and "no more than any joint has" in note]
    assert len(told) == (not named)
    shown = Console(file=io.StringIO(), width=400)
    shown.print(summary(found))
    assert all(note in shown.file.getvalue() for note in told)  # type: ignore[attr-defined]
    assert [entry.effect for entry in found.models["retuned"].effects] == ["presliding"] * (not named)
    assert [entry.effect for entry in found.models["corrected"].effects] == ["presliding"]


WAVE = {"sine": 0.01, "cosine": 0.01, "harmonic": 3.0}
SLOTS = ("cogging", {"amplitude": 0.06, "harmonic": 11.0})
COGGING = effect_named("cogging")
CLEFT = {"sine": 0.03, "cosine": 0.03, "harmonic": 11.0}


def step_of(prepared: Prepared, base: Model, *might: tuple[str, dict[str, float]]) -> Step:
    """A step that takes the first of some effects, and might as well take the others."""
    weights = weights_of(base, prepared, FLOOR)
    rivals = tuple(fit_model(prepared, (Placed(effect_named(name), 0, values),), weights) for name, values in might)
    ranking = replace(rank(prepared, [base, *rivals], FLOOR, 0), best=1)
    return Step(base, rivals, ranking, tuple(range(1, len(rivals) + 1)), (), FLOOR)


@pytest.mark.parametrize(
    ("hidden", "beside"),
    [((), ("position_dependent_friction",)), ((SLOTS,), ("position_dependent_friction", "cogging"))],
)
def test_what_might_stand_beside_is_taken_in_where_it_is_needed(
    hidden: tuple[tuple[str, dict[str, float]], ...], beside: tuple[str, ...]
) -> None:
    """With it, then without; where nothing asks for it, that is the same, and is said once."""
    prepared = prepare(NOMINAL, recorded(TEXTURE, *hidden, noise=1e-6))
    base = retune(prepared, FLOOR)
    step = step_of(prepared, base, ("position_dependent_friction", WAVE), ("cogging", CLEFT))
    found = [
        tuple(place.effect.name for place in again.placed)
        for again in retuned_with(prepared, FLOOR, base, 0, [step], 0)
    ]
    alone = ("position_dependent_friction",)
    assert found == ([beside] if beside == alone else [beside, alone])


def test_a_wave_keeps_its_pitch_where_what_stood_beside_it_is_taken_out() -> None:
    """Most of the residual is then another law's, and a wave that follows that would go where none is."""
    prepared = prepare(NOMINAL, recorded(SLOTS, ("quadratic_damping", {"coefficient": 0.4}), noise=1e-6))
    base = retune(prepared, FLOOR)
    drag, slots = Placed(effect_named("quadratic_damping"), 0, {"coefficient": 0.4}), Placed(COGGING, 0, CLEFT)
    dragged = fit_model(prepared, (drag,), weights_of(base, prepared, FLOOR))
    model = fit_model(prepared, (*dragged.placed, slots), weights_of(dragged, prepared, FLOOR), dragged.fit, CLEFT)
    step = Step(base, (model,), rank(prepared, [base, model], FLOOR, 0), (1,), (), FLOOR)
    (again,) = retuned_with(prepared, FLOOR, base, 0, [step], 0)
    (place,) = again.placed
    assert place.key == ("cogging", 0)
    assert place.values["harmonic"] == pytest.approx(11.0, rel=0.01)
    assert place.values["harmonic"] == model.placed[1].values["harmonic"]
    assert place.values["sine"] != model.placed[1].values["sine"]
    further = fit_model(prepared, (*again.placed, drag), weights_of(again, prepared, FLOOR), again.fit)
    assert further.placed[0].values["harmonic"] == place.values["harmonic"]


def test_a_fit_that_ran_away_is_not_the_one_without_an_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    prepared = prepare(NOMINAL, recorded(TEXTURE, noise=1e-6))
    model = retune(prepared, FLOOR, (Placed(effect_named("torque_offset"), 0),))
    away = replace(model, placed=(), held=np.full_like(model.held, np.nan))
    monkeypatch.setattr(ordinary_module, "fit_model", lambda *_: away)
    assert _needed_of(prepared, FLOOR, model, 0, 0) is model


def test_what_is_taken_beside_others_and_no_more_than_any_joint_has_is_told_of() -> None:
    drag, slots = (
        Placed(effect_named("quadratic_damping"), 0, {"coefficient": 0.4}),
        Placed(COGGING, 0, {"sine": 0.1, "cosine": 0.05, "harmonic": 11.0}),
    )
    steps = taken_steps([drag, slots], [9.0, 3.0], gap=np.ones(1), floor=np.ones(1))
    (note,) = told_unnamed(steps, (SCALE,), NOMINAL)
    assert note.startswith("A: cogging/one_wave (amplitude of the sine 0.1 N m,")
    assert note.endswith("no more than any joint has; not named")
    (note,) = told_unnamed(steps, (SCALE,), NOMINAL, beside=True)
    assert note.endswith("no more than any joint has; in the corrected model, and not named")
    assert told_unnamed(steps[:1], (SCALE,), NOMINAL) == []


@pytest.mark.long
def test_a_diagnosis_tells_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where re-tuning with it is not tried, the step of the search that took it stays."""
    monkeypatch.setattr(search_module, "MOST_ROUNDS", 0)
    found = diagnose(NOMINAL, recorded(TEXTURE, noise=1e-6), jobs=1, leave_out=OTHERS)
    assert not found.named
    (note,) = (note for note in found.notes if note.endswith("not named"))
    assert "position_dependent_friction" in note
