"""What C and Python both write down: a library whose fields, size or names differ from their mirror is not used."""

import ctypes
from collections.abc import Callable

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.compiler import build, load
from stribeck.errors import StribeckError
from stribeck.identify import tape
from stribeck.loop.exact import wish
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.maps import cells
from stribeck.mirrored import check_names, check_structure
from stribeck.simulate import Engine, JointLoop, Loop, Reference, path_of
from stribeck.simulate import axis as axis_module
from stribeck.simulate.controller import Controller

FRICTION = Friction(5.0, 1.25, 1.5, 0.05)
ARM = Arm("one joint", (0.0, 0.0), (Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.5, 0.5, FRICTION, FRICTION),))


def other_order(mirror: type[ctypes.Structure] | np.dtype) -> type[ctypes.Structure] | np.dtype:
    """A mirror whose last two fields have changed places."""
    if isinstance(mirror, np.dtype):
        fields = [(name, mirror[name]) for name in mirror.names or ()]
        return np.dtype([*fields[:-2], fields[-1], fields[-2]])
    swapped = [*mirror._fields_[:-2], mirror._fields_[-1], mirror._fields_[-2]]
    return type("Swapped", (ctypes.Structure,), {"_fields_": swapped})


def engine() -> object:
    return Engine(path_of(ARM)).library


def controller() -> object:
    regulate = Reference("regulate", initial_error=0.5)
    return Controller(ARM, Loop(0.001, 1.0, (JointLoop("A", 30.0, regulate),)))


def rounds() -> object:
    return RoundsEngine(ARM).rounds_library


MIRRORS = {
    "axis": (axis_module, "Axis", engine),
    "memory": (axis_module, "MEMORY", engine),
    "laws": (axis_module, "KINDS", engine),
    "at zero": (axis_module, "AT_ZERO", engine),
    "courses": (axis_module, "COURSES", engine),
    "axis of a controller": (axis_module, "Axis", controller),
    "axis of rounds": (axis_module, "Axis", rounds),
    "wish": (wish, "Wish", rounds),
    "turn": (wish, "TURN", rounds),
    "cell": (cells, "CELL", cells.kernel.__wrapped__),
    "laws of cells": (cells, "KINDS", cells.kernel.__wrapped__),
    "at zero of cells": (cells, "AT_ZERO", cells.kernel.__wrapped__),
    "verdicts": (cells, "VERDICTS", cells.kernel.__wrapped__),
    "argument": (tape, "Argument", tape.library.__wrapped__),
    "kinds": (tape, "KINDS", tape.library.__wrapped__),
}


@pytest.mark.parametrize(("module", "name", "opened"), MIRRORS.values(), ids=MIRRORS)
def test_another_order_is_noticed_when_a_library_is_loaded(
    module: object, name: str, opened: Callable[[], object], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened()
    mirror = getattr(module, name)
    changed = (*mirror[:-2], mirror[-1], mirror[-2]) if isinstance(mirror, tuple) else other_order(mirror)
    monkeypatch.setattr(module, name, changed)
    with pytest.raises(StribeckError, match=r"differ at place \d+: found \w+ in C, \w+ in Python; write them alike"):
        opened()


@pytest.fixture(scope="module")
def library() -> ctypes.CDLL:
    text = 'const char *pair_fields(void) { return "double first;int second[2][3];"; }\n'
    text += "long long pair_size(void) { return 32; }\n"
    text += 'const char *words_names(void) { return "ONE;TWO_THREE;"; }\n'
    return load(build(text))


PAIR = [("first", float), ("second", np.int32, (2, 3))]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        (PAIR[:1], "the fields of pair differ at place 1: found second in C, nothing in Python"),
        ([*PAIR, ("third", float)], "the fields of pair differ at place 2: found nothing in C, third in Python"),
        ([PAIR[0], ("second", float)], "the size of pair differs: found 32 bytes in C, 16 in Python"),
    ],
)
def test_a_field_more_or_less_and_another_size(library: ctypes.CDLL, fields: list, message: str) -> None:
    check_structure(library, "pair", np.dtype(PAIR))
    with pytest.raises(StribeckError, match=message):
        check_structure(library, "pair", np.dtype(fields))


def test_names_in_capitals_are_those_of_python(library: ctypes.CDLL) -> None:
    check_names(library, "words", ("one", "two_three"))
    with pytest.raises(StribeckError, match="words differ at place 1: found two_three in C, two in Python"):
        check_names(library, "words", ("one", "two"))
