"""A laboratory and a diagnoser of straw: the torque of a recording says what is hidden, so every answer is known.

Everything that other processes are to run is defined inside a function: it is then sent to them by value, and they
need not find this file.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from stribeck.withheld.plan import Order
from stribeck.withheld.seal import record_sealed

NAMES = ("delay", "payload", "torque_gain")


def straw_maker() -> Callable[..., Any]:
    """Return a maker of cases: torque k + 1 where the k-th name is hidden, 10 where two are, 0 where none is."""

    def make(seed: int, plan: Any) -> Any:
        import numpy as np

        from stribeck.arm import Arm, Friction, Joint
        from stribeck.run import Run
        from stribeck.withheld.cases import Case

        names = ("delay", "payload", "torque_gain")
        f = Friction(1.0, 0.0, 0.1, 0.1)
        arm = Arm("straw", (0.0, 0.0), (Joint("A", "revolute", 0.3, 1.0, (0.1, 0.0), 0.01, 0.0, f, f),))
        t = 0.01 * np.arange(20)
        one = 1.0 + names.index(plan.effects[0]) if plan.effects and plan.effects[0] in names else 20.0
        level = 0.0 if not plan.effects else 10.0 if len(plan.effects) == 2 else one
        strength = {"clear": 4.0, "medium": 2.0, "weak": 0.5}[plan.level]
        effects = [
            {"effect": e, "joint": "A", "parameters": {"time": 0.01, "mass": 0.2}, "strength": strength}
            for e in plan.effects
        ]
        truth = {"seed": seed, "level": plan.level if effects else None, "effects": effects, "disturbances": []}
        truth |= {"known": all(e in names for e in plan.effects), "worth": {"A": 0.1}}
        runs = (Run("run_00", t, np.sin(t)[:, None], np.full((20, 1), level) + 1e-3 * np.sin(seed + t)[:, None]),)
        return Case(arm, arm, runs, truth)

    return make


def straw_diagnoser(hook: Callable[[float], None] = lambda level: None) -> Callable[..., dict[str, Any]]:
    """Return a diagnoser that reads the torque; `hook` is called with it before, in the process that works."""

    def answer(arm: Any, runs: Any, leave_out: Any) -> dict[str, Any]:
        level = round(float(runs[0].tau.mean()))
        hook(level)
        names = ("delay", "payload", "torque_gain")
        named = [names[level - 1]] if 1 <= level <= 3 else list(names[:2]) if level == 10 else []
        named = [name for name in named if name not in leave_out]
        ci = {"value": 0.01, "unit": "s", "ci95": [0.009, 0.011]}
        causes = [
            {"effect": n, "joints": ["A"], "probability": 0.9 / len(named), "presence": 0.9, "equivalent": [n],
             "parameters": {"A": {"time": ci}} if n == "delay" else {}, "closes": None}
            for n in named
        ]  # fmt: skip
        silent = "no_gap" if level == 0 else "unexplained"
        rest = [] if named else [{"effect": "none", "probability": 0.8 if level == 0 else 0.1}]
        rest.append({"effect": "unknown", "probability": 1.0 - sum(c["probability"] for c in [*causes, *rest])})
        diagnosis = {
            "verdict": "explained" if named else silent, "named": named, "causes": [*causes, *rest], "where": [],
            "gap": {"closed": {"value": 0.9, "ci95": [0.8, 1.0]} if named else None}, "settings": {"cutoff_hz": 10.0},
        }  # fmt: skip
        return {"diagnosis": diagnosis, "retuned": "", "corrected": ""}

    return answer


@pytest.fixture
def sealed(tmp_path: Path) -> tuple[Path, Path]:
    """Ten cases of straw, and their key."""
    order = Order(single=4, pairs=1, none=2, unknown=2, left_out=1, effects=NAMES, levels=("clear",), joints=(1,))
    record_sealed(order, tmp_path / "cases", tmp_path / "key.json", seed=5, jobs=1, make=straw_maker())
    return tmp_path / "cases", tmp_path / "key.json"


@pytest.fixture
def straw() -> Callable[..., dict[str, Any]]:
    """The diagnoser of straw."""
    return straw_diagnoser()


@pytest.fixture
def straw_with() -> Callable[..., Callable[..., dict[str, Any]]]:
    """Make a diagnoser of straw with a hook."""
    return straw_diagnoser


@pytest.fixture
def maker() -> Callable[..., Any]:
    """The maker of cases of straw."""
    return straw_maker()
