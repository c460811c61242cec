"""Weights of evidence from cases: known weights come back, and what was hidden is judged by class."""

import importlib
from dataclasses import astuple

import numpy as np
import pytest

from stribeck.gap.search.presence import CENTRE, LEVEL, WEIGHT, Evidence


def study(name: str):
    return getattr(importlib.import_module("_presence"), name)


EMPTY = {"t": 1.0, "gain": 0.5, "size": 0.5, "removed": 0.2, "elusive": 0.0, "elusive_gain": 0.0, "left": 0.1}


def drawn(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Evidence (M, figures) around the shipped centre, and whether the effect was there by the shipped weights."""
    rng = np.random.default_rng(0)
    spread = np.array([0.6, 1.0, 1.2, 1.2, 0.4, 0.3, 0.5])
    figures = np.array(astuple(CENTRE)) + rng.normal(size=(count, len(spread))) * spread
    return figures, (rng.uniform(size=count) < study("chances")(figures, CENTRE, WEIGHT, LEVEL)).astype(float)


def test_weights_come_back():
    figures, right = drawn(20_000)
    centre, weight, level = study("regression")(figures, right)
    shift = float((np.array(astuple(CENTRE)) - np.array(astuple(centre))) @ np.array(astuple(WEIGHT)))
    assert np.array(astuple(weight)) == pytest.approx(np.array(astuple(WEIGHT)), abs=0.25)
    assert level + shift == pytest.approx(LEVEL, abs=0.15)


def test_what_never_varies_weighs_nothing():
    figures, right = drawn(500)
    figures[:, 3:] = 0.0
    _, weight, _ = study("regression")(figures, right)
    assert abs(weight.elusive) < 1e-6
    assert abs(weight.elusive_gain) < 1e-6


def test_cross_validation_costs_little_and_never_sees_its_own_case():
    figures, right = drawn(2000)
    case = [f"case_{i // 2}" for i in range(2000)]
    crossed = study("cross_validated")(figures, right, case)
    own = study("chances")(figures, *study("regression")(figures, right))
    assert study("log_loss")(own, right) < study("log_loss")(crossed, right) < study("log_loss")(own, right) + 0.02
    turned = right.copy()
    turned[:2] = 1.0 - turned[:2]
    assert study("cross_validated")(figures, turned, case)[:2] == pytest.approx(crossed[:2])


def test_an_effect_left_out_is_not_there_to_be_found():
    truths = {
        "a": {"effects": [{"effect": "delay"}], "leave_out": []},
        "b": {"effects": [{"effect": "delay"}], "leave_out": ["delay", "contact"]},
        "c": {"effects": [], "leave_out": []},
    }
    found = [{"class": ["actuator_lag", "delay"], **EMPTY}]
    answers = {"a": {"evidence": found}, "b": {"evidence": found}, "c": {"evidence": []}}
    figures, right, case = study("judged")(truths, answers)
    assert right.tolist() == [1.0, 0.0]
    assert case == ["a", "b"]
    assert Evidence(*figures[0]) == Evidence(**EMPTY)
