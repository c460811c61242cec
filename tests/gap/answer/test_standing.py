"""What is named must hold in the model that is delivered."""

from collections.abc import Mapping
from types import MappingProxyType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.answer import standing as module
from stribeck.gap.answer.standing import Standing, _idle, chain_of, gained, standing
from stribeck.gap.result import Cause, Estimate
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale

ONE_JOINT: Any = SimpleNamespace(arm=SimpleNamespace(names=("A",)), scales=(Scale(10.0, 4.0, 1.0, 1.0, 1.0, 1e-3),))
CLOSES = {"delay": 0.9, "cogging": -0.02, "payload": 0.02, "torque_gain": 0.02}
LEFT = ((1.0, 1.0), (0.3, 1.0), (0.3, 1.1), (0.299, 1.09), (0.299, 1.0))  # N m rms, after one effect more each


def delivered() -> list[Any]:
    """The re-tuned model of two joints, and one more for each effect."""
    names = (None, *CLOSES)
    placed = [(Placed(effect_named(name), 0),) if name else () for name in names]
    return [SimpleNamespace(placed=p, held=np.full((9, 2), 1.0) * left) for p, left in zip(placed, LEFT, strict=True)]


def test_what_hardly_closes_anything_without_the_others_is_idle() -> None:
    """A payload that takes two per cent off, and a gain that takes sixteen, off one joint of two."""
    closing: Any = SimpleNamespace(by_effect=lambda effect, chain: Estimate(CLOSES[effect], -1.0, 1.0))
    assert _idle(tuple(CLOSES), delivered(), closing) == ["cogging", "payload"]


@pytest.mark.parametrize(("as_searched", "sure"), [(True, 0.9), (False, 0.45)])
def test_what_the_search_left_is_not_idle(monkeypatch: pytest.MonkeyPatch, as_searched: bool, sure: float) -> None:
    found = standing_of(monkeypatch, ("delay", "cogging"), as_searched=as_searched)
    assert [cause.presence for cause in found.causes] == [0.9, sure]
    assert len(found.chain) == (3 if as_searched else 2)


def test_what_sends_the_arm_astray_is_not_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The model that is delivered is made without it, and looked at again."""
    found = standing_of(monkeypatch, ("delay", "cogging"), astray={"cogging": 9.0, "payload": 7.0})
    assert (found.strayed, len(found.chain)) == ({"cogging": 9.0}, 2)
    assert [cause.presence for cause in found.causes] == [0.9, 0.45]
    assert found.left_over == 0.625


def standing_of(
    monkeypatch: pytest.MonkeyPatch,
    names: tuple[str, ...],
    *,
    as_searched: bool = True,
    astray: Mapping[str, float] = MappingProxyType({}),
) -> Standing:
    """What stands of effects that a search is sure of, took alone or not, and with all of which the arm goes astray."""
    chain = delivered()[: 1 + len(names)]
    monkeypatch.setattr(
        module, "causes_of", lambda *_: ([Cause(name, 0.25, ("A",), (name,), presence=0.9) for name in names], 0.5)
    )
    monkeypatch.setattr(module, "chain_of", lambda prepared, models, floor, named: chain[: 1 + len(named)])
    closing: Any = SimpleNamespace(by_effect=lambda effect, chain: Estimate(CLOSES[effect], -1.0, 1.0))
    motions: Any = SimpleNamespace(strayed=lambda models: astray if len(models) == len(chain) else {})
    prepared: Any = SimpleNamespace(arm=SimpleNamespace(names=()), scales=())
    return standing(prepared, (), chain if as_searched else delivered(), np.ones(2), closing, motions)


def test_a_gain_counts_at_the_joint_that_gains_most() -> None:
    chain = delivered()
    assert gained("delay", chain) == pytest.approx(1.0 - 0.3**2)
    assert gained("torque_gain", chain) == pytest.approx(1.0 - (1.0 / 1.09) ** 2)
    assert gained("backlash", chain) == -np.inf


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
    models: list[Any] = [SimpleNamespace(placed=tuple(found[:k]), fit=f"fit {k}") for k in range(4)]
    starts: list[Any] = []

    def fit_model(prepared: Any, placed: Any, weights: Any, known: Any, *, evaluations: int) -> Any:
        starts.append(known)
        return SimpleNamespace(placed=placed, fit="own")

    monkeypatch.setattr(module, "fit_model", fit_model)
    monkeypatch.setattr(module, "weights_of", lambda *_: None)
    chain = chain_of(ONE_JOINT, models, np.ones(1), [Cause(name, 0.9, ("A",), (name,)) for name in named])
    assert [[place.key[0] for place in model.placed] for model in chain] == [
        list(named[:k]) for k in range(len(named) + 1)
    ]
    assert chain[: taken_over + 1] == models[: taken_over + 1]
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
    models: list[Any] = [SimpleNamespace(placed=tuple(found[:k]), fit=None) for k in range(4)]
    monkeypatch.setattr(module, "fit_model", lambda _, placed, *__, **___: SimpleNamespace(placed=placed, fit=None))
    monkeypatch.setattr(module, "weights_of", lambda *_: None)
    chain = chain_of(ONE_JOINT, models, np.ones(1), [Cause(name, 0.9, ("A",), (name,)) for name in named])
    assert tuple(place.effect.name for place in chain[-1].placed) == delivered


@pytest.mark.parametrize(("held", "gain"), [([[2.0, 0.0]], 0.75), ([[0.0, 0.0]], -np.inf)])
def test_a_joint_that_a_brake_holds_gains_nothing(held: list[list[float]], gain: float) -> None:
    before: Any = SimpleNamespace(held=np.array(held), placed=())
    after: Any = SimpleNamespace(held=0.5 * np.array(held), placed=(Placed(effect_named("delay"), 0),))
    assert gained("delay", [before, after]) == gain
