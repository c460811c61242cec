"""What is named must hold in the model that is delivered."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.answer import assembly as module
from stribeck.gap.answer.assembly import Assembly, gained
from stribeck.gap.records.blocks import bayesian_bootstrap
from stribeck.gap.result import Cause, Estimate
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale

SCALE = Scale(10.0, 4.0, 1.0, 1.0, 1.0, 1e-3)
CLOSES = {"delay": 0.9, "cogging": -0.02, "payload": 0.02, "torque_gain": 0.02}
LEFT = ((1.0, 1.0), (0.3, 1.0), (0.3, 1.1), (0.299, 1.09), (0.299, 1.0))  # N m rms, after one effect more each


def delivered() -> list[Any]:
    """The re-tuned model of two joints, and one more for each effect."""
    names = (None, *CLOSES)
    placed = [(Placed(effect_named(name), 0),) if name else () for name in names]
    return [SimpleNamespace(placed=p, held=np.full((9, 2), 1.0) * left) for p, left in zip(placed, LEFT, strict=True)]


def test_what_hardly_closes_anything_without_the_others_is_idle(monkeypatch: pytest.MonkeyPatch) -> None:
    """A payload that takes two per cent off, and a gain that takes sixteen, off one joint of two."""
    assembly, chain = object.__new__(Assembly), delivered()
    assembly.models = []
    monkeypatch.setattr(assembly, "_closed_by", lambda effect, chain: Estimate(CLOSES[effect], -1.0, 1.0))
    assert assembly._idle(tuple(CLOSES), chain) == ["cogging", "payload"]
    assert assembly._idle(tuple(CLOSES), assembly.models) == []  # as the search left it


def test_what_sends_the_arm_astray_is_not_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The model that is delivered is made without it, and looked at again."""
    assembly, chain = object.__new__(Assembly), delivered()
    found = [Cause(name, 0.25, ("A",), (name,), presence=0.9) for name in ("delay", "cogging")]
    assembly.steps = ()
    assembly.prepared = SimpleNamespace(arm=SimpleNamespace(names=()), scales=())  # type: ignore[assignment]
    monkeypatch.setattr(module, "causes_of", lambda *_: (found, 0.5))
    monkeypatch.setattr(assembly, "_chain", lambda named, causes: chain[: 1 + len(named)])
    monkeypatch.setattr(assembly, "_idle", lambda named, chain: [])
    motions: Any = SimpleNamespace(strayed=lambda chain: {"cogging": 9.0, "payload": 7.0} if len(chain) > 2 else {})
    causes, left, models, strayed = assembly._standing(motions)
    assert (causes[0], strayed, len(models)) == (found[0], {"cogging": 9.0}, 2)
    assert (causes[1].presence, left) == (0.45, 0.625)


@pytest.mark.parametrize(("width", "high"), [(0.04, 0.98), (0.4, 1.0)])
def test_no_effect_closes_more_than_there_is(monkeypatch: pytest.MonkeyPatch, width: float, high: float) -> None:
    assembly, chain = object.__new__(Assembly), delivered()[:2]
    assembly.draws = np.ones((80, 1))
    monkeypatch.setattr(assembly, "_closed", lambda model: drawn(0.96, 0.96 - width / 2, 0.96 + width / 2))
    closes = assembly._closed_by(chain[1].placed[-1].effect.name, chain)
    assert closes.high == pytest.approx(high)
    assert closes.low == pytest.approx(0.96 - width / 2)


def drawn(value: float, low: float, high: float) -> np.ndarray:
    """A value, and what it is in eighty draws: one of two bounds."""
    return np.array([value, *np.repeat([low, high], 40)])


def test_the_only_effect_closes_what_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the same interval, which is not symmetrical; and what several close adds up, draw by draw."""
    answer, chain = object.__new__(Assembly), delivered()[:3]
    size = np.random.default_rng(0).uniform(0.2, 3.0, (90, 1))
    held = {id(model): size**k * left for k, (model, left) in enumerate(zip(chain, ([3.0], [1.5], [1.2]), strict=True))}
    answer.base, answer.heard = chain[0], SimpleNamespace(floor=np.ones(1))  # type: ignore[assignment]
    answer.block, answer.draws = np.repeat(np.arange(9), 10), bayesian_bootstrap(9, 400, np.random.default_rng(1))
    monkeypatch.setattr(answer, "_held", lambda model: held[id(model)])
    alone = answer._closed_by("delay", chain[:2])
    assert alone == answer._closes(chain[1])
    assert abs(alone.high + alone.low - 2.0 * alone.value) > 0.01 * (alone.high - alone.low)
    first, second = (answer._closed_by(name, chain) for name in ("delay", "cogging"))
    assert first == alone
    assert first.value + second.value == pytest.approx(answer._closes(chain[2]).value)
    assert second.low < second.value < second.high < 0.0  # it makes it worse, in every draw


def test_a_draw_without_a_gap_tells_no_number(monkeypatch: pytest.MonkeyPatch) -> None:
    """Little above the floor, any part of nothing: an interval had reached down to -6e9 per cent."""
    answer, chain = object.__new__(Assembly), delivered()[:2]
    size = np.random.default_rng(0).uniform(0.2, 1.65, (90, 1))
    answer.base, answer.heard = chain[0], SimpleNamespace(floor=np.ones(1))  # type: ignore[assignment]
    answer.block, answer.draws = np.repeat(np.arange(9), 10), bayesian_bootstrap(9, 400, np.random.default_rng(1))
    for more, low in ((1.01, -1.0), (1.2, None)):
        monkeypatch.setattr(answer, "_held", lambda model: size * (1.0 if model is chain[0] else more))  # noqa: B023
        closes = answer._closes(chain[1])
        assert closes.low == (closes.value if low is None else low)
        assert closes.low <= closes.value < 0.0


def test_a_gain_counts_at_the_joint_that_gains_most() -> None:
    chain = delivered()
    assert gained("delay", chain) == pytest.approx(1.0 - 0.3**2)
    assert gained("torque_gain", chain) == pytest.approx(1.0 - (1.0 / 1.09) ** 2)
    assert gained("backlash", chain) == -np.inf


def test_no_effect_closes_more_than_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor does the interval of what it closes, which is of what it closes draw by draw."""
    answer, chain = object.__new__(Assembly), delivered()
    closed = dict(zip(map(id, chain[1:]), (drawn(v, v - 0.1, v + 0.02) for v in (0.98, -0.1, 0.5, 1.0)), strict=True))
    answer.draws = np.ones((80, 1))
    monkeypatch.setattr(answer, "_closed", lambda model: closed[id(model)])
    found = {effect: answer._closed_by(effect, chain) for effect in CLOSES}
    assert (found["delay"].value, found["delay"].high) == (0.98, 1.0)
    assert found["delay"].low == pytest.approx(0.98 - 0.1)
    assert found["payload"].value == pytest.approx(0.6)
    assert all(estimate.low <= estimate.value <= estimate.high <= 1.0 for estimate in found.values())


@pytest.mark.parametrize(
    ("named", "taken_over", "fitted"),
    [(("delay", "cogging"), 2, 0), (("delay", "payload"), 1, 3), (("cogging",), 0, 3), ((), 0, 0)],
)
def test_what_is_delivered_starts_from_what_the_search_came_to(
    monkeypatch: pytest.MonkeyPatch, named: tuple[str, ...], taken_over: int, fitted: int
) -> None:
    """Its own models, as far as they are of the same effects; the others are fitted from its last one."""
    values = {"delay": {"time": 0.02}, "cogging": {"sine": 9.0, "cosine": 0.0, "harmonic": 7.0}, "payload": {}}
    found = [Placed(effect_named(name), 0, own) for name, own in values.items()]
    answer = object.__new__(Assembly)
    answer.models = [SimpleNamespace(placed=tuple(found[:k]), fit=f"fit {k}") for k in range(4)]  # type: ignore[misc]
    answer.base, answer.floor = answer.models[0], np.ones(1)
    answer.prepared = SimpleNamespace(arm=SimpleNamespace(names=("A",)), scales=(SCALE,))  # type: ignore[assignment]
    starts: list[Any] = []

    def fit_model(prepared: Any, placed: Any, weights: Any, known: Any, *, evaluations: int) -> Any:
        starts.append(known)
        return SimpleNamespace(placed=placed, fit="own")

    monkeypatch.setattr(module, "fit_model", fit_model)
    monkeypatch.setattr(module, "weights_of", lambda *_: None)
    chain = answer._chain(named, [Cause(name, 0.9, ("A",), (name,)) for name in named])
    assert [[place.key[0] for place in model.placed] for model in chain] == [
        list(named[:k]) for k in range(len(named) + 1)
    ]
    assert chain[: taken_over + 1] == answer.models[: taken_over + 1]
    assert starts == ["fit 3", "own", "own"][:fitted]


@pytest.mark.parametrize(
    ("named", "delivered"), [(("payload",), ("torque_offset", "payload")), ((), ())], ids=["beside a name", "alone"]
)
def test_what_every_arm_has_is_delivered_beside_what_is_named(
    monkeypatch: pytest.MonkeyPatch, named: tuple[str, ...], delivered: tuple[str, ...]
) -> None:
    """Else what is too little to be named would stay a gap of the corrected model."""
    values = {
        "torque_offset": {"offset": 0.01},
        "cogging": {"sine": 9.0, "cosine": 0.0, "harmonic": 7.0},
        "payload": {},
    }
    found = [Placed(effect_named(name), 0, own) for name, own in values.items()]
    answer = object.__new__(Assembly)
    answer.models = [SimpleNamespace(placed=tuple(found[:k]), fit=None) for k in range(4)]  # type: ignore[misc]
    answer.base, answer.floor = answer.models[0], np.ones(1)
    answer.prepared = SimpleNamespace(arm=SimpleNamespace(names=("A",)), scales=(SCALE,))  # type: ignore[assignment]
    monkeypatch.setattr(module, "fit_model", lambda _, placed, *__, **___: SimpleNamespace(placed=placed, fit=None))
    monkeypatch.setattr(module, "weights_of", lambda *_: None)
    chain = answer._chain(named, [Cause(name, 0.9, ("A",), (name,)) for name in values])
    assert tuple(place.effect.name for place in chain[-1].placed) == delivered


@pytest.mark.parametrize(("held", "gain"), [([[2.0, 0.0]], 0.75), ([[0.0, 0.0]], -np.inf)])
def test_a_joint_that_a_brake_holds_gains_nothing(held: list[list[float]], gain: float) -> None:
    before: Any = SimpleNamespace(held=np.array(held), placed=())
    after: Any = SimpleNamespace(held=0.5 * np.array(held), placed=(Placed(effect_named("delay"), 0),))
    assert gained("delay", [before, after]) == gain
