"""Ctrl-C while a fit runs ends it at once, whatever the solver makes of exceptions."""

import signal
import threading
from collections.abc import Iterator

import pytest

from stribeck.identify.interrupts import held_back
from stribeck.identify.map_fit import fit
from stribeck.identify.problem import Problem
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath

from .conftest import pendulum
from .test_fit import SURE, clean, perturbed


@pytest.fixture(autouse=True)
def _heard() -> Iterator[None]:
    """A shell that starts the tests in the background has them ignore Ctrl-C."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_ends_a_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    path = SignalPath(pendulum())
    residual = Residual(path, [clean(path, perturbed(path))])
    evaluate, calls = Problem.evaluate, []

    def interrupted(self: Problem, z):  # type: ignore[no-untyped-def]
        calls.append(1)
        if len(calls) == 2:
            signal.raise_signal(signal.SIGINT)
        return evaluate(self, z)

    monkeypatch.setattr(Problem, "evaluate", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fit(residual, SURE, tolerance=1e-12)
    assert len(calls) < 8
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_signal_comes_after_and_an_error_is_not_lost() -> None:
    come: list[int] = []
    with pytest.raises(KeyboardInterrupt) as caught, held_back(come):
        signal.raise_signal(signal.SIGINT)
        assert come == [signal.SIGINT]
        raise ValueError("of the solver")
    assert isinstance(caught.value.__context__, ValueError)


def test_other_threads_have_no_signals_to_hold() -> None:
    def held() -> None:
        with held_back([]):
            seen.append(signal.getsignal(signal.SIGINT))

    seen: list[object] = []
    thread = threading.Thread(target=held)
    thread.start()
    thread.join()
    assert seen == [signal.default_int_handler]
