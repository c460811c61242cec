"""What an identification takes for each direction, and what stays as the arm file has it."""

from types import SimpleNamespace

import numpy as np
import pytest

from stribeck.arm import Friction
from stribeck.identify.findings import JointFriction
from stribeck.identify.taken import taken_arm

from .bench import BACKWARD, FORWARD, joint

FOUND = {"forward": Friction(4.6, 1.6, 1.4, 0.06), "backward": Friction(4.1, 1.1, 1.3, 0.07)}


def taken(ways: dict[str, str], stated: tuple[Friction, Friction]) -> tuple[Friction, Friction]:
    """Return both directions' friction where runs show some ``ways``, each with its source."""
    constants = {way: np.array([f.C0, f.C1, f.C2, f.alpha]) for way, f in FOUND.items()}
    directions = {
        way: SimpleNamespace(source=source, curve=SimpleNamespace(constants=constants[way]), runs=[constants[way]])
        for way, source in ways.items()
    }
    arm = joint(*stated)
    whole = SimpleNamespace(arm=arm, fit=SimpleNamespace(ok=True))
    found = JointFriction("A", directions, None, None)  # type: ignore[arg-type]
    (own,) = taken_arm(arm, [found], whole).joints  # type: ignore[arg-type]
    return own.friction, own.backward


@pytest.mark.parametrize("source", ["curve", "runs"])
@pytest.mark.parametrize("way", ["forward", "backward"])
def test_a_direction_that_no_run_shows_stays_as_stated(way: str, source: str) -> None:
    stated = {"forward": FORWARD, "backward": BACKWARD}
    expected = stated | {way: FOUND[way]}
    assert taken({way: source}, (FORWARD, BACKWARD)) == tuple(expected.values())


@pytest.mark.parametrize("way", ["forward", "backward"])
def test_what_the_file_states_for_both_is_found_for_both(way: str) -> None:
    """Nothing is told apart there."""
    assert taken({way: "curve"}, (FORWARD, FORWARD)) == (FOUND[way], FOUND[way])


def test_a_direction_that_is_shown_but_open_is_as_the_other() -> None:
    found = taken({"forward": "other direction", "backward": "curve"}, (FORWARD, BACKWARD))
    assert found == (FOUND["backward"], FOUND["backward"])


def test_a_direction_alone_that_is_open_changes_nothing() -> None:
    assert taken({"forward": "nominal"}, (FORWARD, BACKWARD)) == (FORWARD, BACKWARD)
