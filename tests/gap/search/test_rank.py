"""Ranking of models on held-out residuals that are drawn, so that the better one is known."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.fitted.model import Model
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.records.spread import Noise
from stribeck.gap.search.rank import Ranking, log_ratio, rank
from stribeck.identify.map_fit import Fit
from stribeck.model.layout import Placed, layout, values_of

from ..conftest import TRUE, sines

FLOOR = np.array([0.05])


@pytest.fixture(scope="module")
def prepared() -> Prepared:
    return prepare(TRUE, [sines(10.0, seed=i, name=f"{i}") for i in range(3)])


def model(every: np.ndarray, effect: str | None = None, prior: float = 0.0) -> Model:
    """A model that left `every` on the fitted and the held-out runs, one after the other."""
    placed = (Placed(effect_named(effect), 0, {}),) if effect else ()
    entries = layout(TRUE, placed)
    p = values_of(entries)
    fitted, held = every[: 2 * len(every) // 3], every[2 * len(every) // 3 :]  # two runs of three, alike in length
    fit = Fit(entries, p, np.arange(2), fitted, np.zeros((len(fitted), 1, 2)), 1.0, prior, "ok", ())
    return Model(placed, fit, held)


def noise(prepared: Prepared, seed: int, size: float = 0.3) -> np.ndarray:
    rows = sum(len(run.analysis_index) for run in (*prepared.fit, *prepared.held))
    return size * np.random.default_rng(seed).standard_normal((rows, 1))


def ranked(prepared: Prepared, *rivals: Model, base: float = 1.0) -> Ranking:
    rest = noise(prepared, 0)
    return rank(prepared, [model(rest + base * np.sign(noise(prepared, 9))), *rivals], FLOOR, 0)


def test_better_model_wins(prepared: Prepared) -> None:
    found = ranked(prepared, model(noise(prepared, 0), "delay"), model(noise(prepared, 0, 1.5), "payload"))
    assert found.best == 1
    assert found.probability.sum() == pytest.approx(1.0)
    assert found.probability[1] > 0.99
    assert found.t[1] > 5.0
    assert found.gain[1, 0] == pytest.approx(1.0 - 0.09 / 1.09, abs=0.05)
    assert found.gain[1, 1] <= found.gain[1, 0] <= found.gain[1, 2]
    assert found.gain[0] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert found.gain[2, 0] < 0.0
    assert found.t[2] < 0.0
    assert found.twins() == [1]


def test_model_that_changes_nothing_gains_nothing(prepared: Prepared) -> None:
    """The same residual with more parameters: the base is as likely or more."""
    found = ranked(prepared, model(noise(prepared, 0), "cable_spring"), base=0.0)
    assert found.gain[1] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert found.t[1] == 0.0
    assert found.probability[0] > 0.9


def test_luck_is_not_taken_for_a_gain(prepared: Prepared) -> None:
    """Two draws of the same noise: neither is better beyond doubt."""
    t = [ranked(prepared, model(noise(prepared, seed), "delay"), base=0.0).t[1] for seed in range(1, 41)]
    assert np.mean(np.abs(t) > 2.8) < 0.1


def test_twins_share(prepared: Prepared) -> None:
    """Two models that leave all but the same are equivalent, and between them certain."""
    twin = noise(prepared, 0) + 0.02 * noise(prepared, 5)
    other = noise(prepared, 0, 0.7)
    found = ranked(
        prepared, model(noise(prepared, 0), "delay"), model(twin, "actuator_lag"), model(other, "torque_gain")
    )
    assert sorted(found.twins()) == [1, 2]
    assert found.probability[[1, 2]].sum() > 0.99


def test_prior_speaks(prepared: Prepared) -> None:
    """Of two that fit alike, the one that strains the nominal values is the less likely."""
    good, strained = model(noise(prepared, 0), "payload"), model(noise(prepared, 0), "cable_spring", prior=20.0)
    found = ranked(prepared, good, strained)
    assert found.best == 1
    assert found.probability[1] > 100 * found.probability[2]
    assert found.prior_gain == pytest.approx([0.0, 0.0, -20.0])
    assert found.twins() == [1]


def test_below_the_floor_nothing_is_gained(prepared: Prepared) -> None:
    """Halving a residual that lies far below the noise floor closes no gap."""
    base, rival = model(noise(prepared, 0, 0.01)), model(0.5 * noise(prepared, 0, 0.01), "delay")
    found = rank(prepared, [base, rival], np.array([1.0]), 0)
    assert abs(found.gain[1, 0]) < 1e-3


def test_gain_is_that_of_the_held_out_runs(prepared: Prepared) -> None:
    """A model that is better only where it was fitted: better overall, without a gain on the rest."""
    base = noise(prepared, 0) + np.sign(noise(prepared, 9))
    fitted_only = base.copy()
    fitted_only[: 2 * len(base) // 3] = noise(prepared, 0)[: 2 * len(base) // 3]
    found = rank(prepared, [model(base), model(fitted_only, "delay")], FLOOR, 0)
    assert found.overall[1] > 0.4
    assert found.gain[1] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert found.power[0] == pytest.approx([1.09 / 0.05**2], rel=0.1)


def test_ranking_is_repeatable(prepared: Prepared) -> None:
    rivals = [model(noise(prepared, 0), "delay"), model(noise(prepared, 1), "payload")]
    base = model(noise(prepared, 2))
    first, again = (rank(prepared, [base, *rivals], FLOOR, 3) for _ in range(2))
    assert (first.probability == again.probability).all()
    assert (first.gain == again.gain).all()


def test_base_alone(prepared: Prepared) -> None:
    found = rank(prepared, [model(noise(prepared, 0))], FLOOR, 0)
    assert found.best == 0
    assert found.probability == pytest.approx([1.0])


def test_log_ratio_is_odd_and_calm() -> None:
    """One violent block counts as one block."""
    a, b = np.array([[1.0], [2.0], [1e6]]), np.array([[1.0], [1.0], [1.0]])
    assert log_ratio(a, b) == pytest.approx(-log_ratio(b, a))
    assert log_ratio(a, b)[2] < 15.0
    assert log_ratio(a, a) == pytest.approx(np.zeros(3))


def test_a_gap_in_quiet_rows_counts_by_their_own_noise(prepared: Prepared) -> None:
    """The same residuals, with and without knowledge of which rows are loud: a small gap shows with it only."""
    drawn = noise(prepared, 0, 1.0)
    loud = np.arange(len(drawn)) % 10 < 3
    scale = np.where(loud, 1.0, 0.1)[:, None]
    gap = np.where(loud, 0.0, 0.3)[:, None] * np.sign(np.sin(np.arange(len(drawn)) / 40.0))[:, None]
    models = [model(scale * drawn + gap), model(scale * drawn, "delay")]
    rows = len(models[0].fit.residual)
    known = replace(prepared, noise=Noise(scale[:rows], scale[rows:]))
    plain, weighted = (rank(one, models, FLOOR * 10.0, 0) for one in (prepared, known))
    assert plain.overall[1] < 0.3
    assert weighted.overall[1] > 2.0 * plain.overall[1]
    assert weighted.t[1] > plain.t[1]


@pytest.mark.parametrize(
    ("record", "command", "first"),
    [(0.02, 0.021, "delay"), (0.02, 0.1, "time_shift"), (-0.02, 0.02, "time_shift")],
)
def test_on_one_joint_a_late_record_is_a_late_command(
    prepared: Prepared, record: float, command: float, first: str
) -> None:
    """The fit to the record is a little better, by luck; one that is early, or late by another time, has no twin."""
    times = {"delay": command, "time_shift": record}
    late = [
        model(noise(prepared, i, size), name) for i, (size, name) in enumerate(zip((0.1, 0.099), times, strict=True))
    ]
    late = [replace(m, placed=(replace(m.placed[0], values={"time": times[m.placed[0].effect.name]}),)) for m in late]
    other = model(noise(prepared, 5, 0.15), "payload")
    found = rank(prepared, [model(noise(prepared, 7)), *late, other], FLOOR, 0)
    assert late[found.best - 1].placed[0].effect.name == first
    assert sorted(found.order) == [1, 2, 3]


def test_records_that_share_a_clock_are_no_late_command(prepared: Prepared) -> None:
    """A command as late as the records of all joints explains one of them."""
    every = model(noise(prepared, 0, 0.099), "time_shift")
    every = replace(every, placed=(Placed(effect_named("time_shift", "all_joints"), 0, {"time": 0.02}),))
    command = model(noise(prepared, 1, 0.1), "delay")
    command = replace(command, placed=(replace(command.placed[0], values={"time": 0.02}),))
    found = rank(prepared, [model(noise(prepared, 7)), command, every], FLOOR, 0)
    assert found.order == (2, 1)


def test_models_without_an_effect_rank_as_well(prepared: Prepared) -> None:
    """As those of two searches, of which one has taken nothing."""
    found = rank(prepared, [model(noise(prepared, 0)), model(noise(prepared, 1, 0.2))], FLOOR, 0)
    assert found.order == (1,)
