"""A recording whose commands were logged late is found among others; a drive that is late is late in all of them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.answer.late_alone import told_late_alone
from stribeck.gap.diagnose import diagnose
from stribeck.gap.records.prepare import prepare
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.tuned import retuned
from stribeck.run import Run

from ..conftest import NOMINAL, recorded


def logged_late(run: Run, rows: int) -> Run:
    tau = np.roll(run.tau, rows, axis=0)
    edge = slice(0, rows) if rows > 0 else slice(rows, None)
    tau[edge] = run.tau[edge]
    return replace(run, tau=tau)


def told(runs: Sequence[Run]) -> list[str]:
    found = retuned(prepare(NOMINAL, runs), Asked(0, 1, (), lambda text: None))
    return told_late_alone(found.prepared, (found.base,), found.noise.rms)


@pytest.mark.parametrize("rows", [-1, 1])
@pytest.mark.parametrize("which", range(4))
def test_one_that_is_a_sample_late_is_told_of(which: int, rows: int) -> None:
    runs = [logged_late(run, rows) if k == which else run for k, run in enumerate(recorded())]
    (said,) = told(runs)
    name, _, text = said.partition(": ")
    assert name == runs[which].name
    assert text.split()[5] == ("later" if rows > 0 else "earlier")
    assert float(text.split()[3]) == pytest.approx(4.0, rel=0.3)  # ms


@pytest.mark.parametrize(
    "effects",
    [
        (),
        (("delay", {"time": 0.012}),),
        (("contact", {"stiffness": 60.0, "position": 1.2, "side": 1.0}),),  # in one recording alone
        (("torque_offset", {"offset": 3.0}),),
    ],
)
def test_none_is_late_alone_for_what_the_arm_does(effects: tuple[tuple[str, dict[str, float]], ...]) -> None:
    assert not told(recorded(*effects))


def test_of_two_either_may_be_late() -> None:
    first, second, *_ = recorded()
    assert not told([logged_late(first, 1), second])


def test_a_diagnosis_warns_of_it() -> None:
    runs = [logged_late(run, 1) if k == 1 else run for k, run in enumerate(recorded())]
    others = [name for name in registry() if name not in ("payload", "cogging")]
    found = diagnose(NOMINAL, runs, jobs=1, leave_out=others)
    assert any(text.startswith(f"{runs[1].name}: commands come about") for text in found.warnings)
