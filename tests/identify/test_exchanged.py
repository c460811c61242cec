"""Position and torque that have changed places are told of; coarse, noisy and rounded records are not."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm
from stribeck.identify.exchanged import exchanged
from stribeck.run import Run

from .conftest import PENDULUM, pendulum, recorded

RESOLUTION = 1e-4


def arm(resolution: float | None) -> Arm:
    return replace(pendulum(), joints=(replace(PENDULUM, encoder_resolution=resolution),))


def counted(*, dq: bool) -> Run:
    """A recording of an encoder with few counts, and a command that is not smooth."""
    run = recorded(noise=1e-5)
    q = 0.3 + RESOLUTION * np.round(run.q / RESOLUTION)
    rough = 0.01 * np.std(run.tau) * np.random.default_rng(0).standard_normal(run.tau.shape)
    return replace(run, q=q, tau=run.tau + rough, dq=np.gradient(q, run.t, axis=0) if dq else None)


@pytest.mark.parametrize(
    ("resolution", "dq", "says"),
    [
        (RESOLUTION, False, "and goes by the encoder's steps"),
        (None, True, "and changes as dq1 says"),
        (None, False, None),
        (0.7 * RESOLUTION, False, None),
    ],
)
def test_columns_that_have_changed_places(resolution: float | None, dq: bool, says: str | None) -> None:
    run = counted(dq=dq)
    assert exchanged(arm(resolution), [run]) == []
    found = exchanged(arm(resolution), [run, replace(run, name="b.csv", q=run.tau, tau=run.q)])
    assert len(found) == (says is not None)
    for text in found:
        assert text.startswith("A: tau1 of b.csv is smoother than its q1, ")
        assert f"{says}: have these columns changed places?" in text


def test_a_rough_position_and_a_smooth_torque_are_no_proof() -> None:
    """A joint that hardly moves under a sine whose log has as few digits as its encoder has counts."""
    run = counted(dq=True)
    sine = np.round(np.sin(run.t[:, None]) / RESOLUTION) * RESOLUTION
    still = RESOLUTION * np.random.default_rng(1).integers(0, 2, run.q.shape)
    dq = np.gradient(still, run.t, axis=0)
    assert exchanged(arm(RESOLUTION), [replace(run, q=still, tau=sine, dq=dq)]) == []
    assert exchanged(arm(RESOLUTION), [replace(run, q=0.0 * still, tau=sine, dq=0.0 * dq)]) == []
