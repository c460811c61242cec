"""Where: regions that partition the samples, and a share that is found where it was put."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck.effects.registry import effect_named
from stribeck.gap.answer.places import _region, places
from stribeck.gap.answer.where import regions
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.records.regions import analysis_signals, motion_masks, region_masks
from stribeck.model.layout import Placed

from ..conftest import TRUE, recorded, sines


@pytest.fixture(scope="module")
def prepared() -> Prepared:
    return prepare(TRUE, recorded())


@pytest.fixture(scope="module")
def two() -> Prepared:
    arm = replace(TRUE, joints=(TRUE.joints[0], replace(TRUE.joints[0], name="B")))
    runs = [sines(3.0, seed=i) for i in range(2)]
    return prepare(arm, [replace(run, q=np.tile(run.q, 2), tau=np.tile(run.tau, 2)) for run in runs])


def assert_partition(prepared: Prepared) -> None:
    rows = sum(len(run.analysis_index) for run in prepared.held)
    for family, masks in region_masks(prepared.held, 0, "revolute").items():
        count = np.zeros(rows)
        for mask in masks.values():
            assert mask.any()
            count += mask
        assert (count == 1.0).all(), family


def test_families_partition_the_samples(prepared: Prepared) -> None:
    assert_partition(prepared)
    assert {"motion", "direction", "position", "load", "acceleration", "time"} <= set(
        region_masks(prepared.held, 0, "revolute")
    )


@settings(max_examples=15)
@given(size=st.sampled_from([1e-6, 1e-3, 0.02, 1.0, 30.0]), seed=st.integers(0, 100))
def test_families_partition_any_motion(size: float, seed: int) -> None:
    assert_partition(prepare(TRUE, [sines(3.0, seed=seed, size=size), sines(3.0, seed=seed + 1, size=size)]))


def test_joint_at_rest_is_stuck() -> None:
    still = [replace(sines(3.0, seed=i), q=np.zeros((600, 1))) for i in range(2)]
    held = prepare(TRUE, still)
    assert_partition(held)
    assert list(motion_masks(held.held, 0)) == ["stuck"]


@pytest.mark.parametrize(("kind", "unit"), [("revolute", "rad"), ("prismatic", "m")])
@pytest.mark.parametrize("size", [1.0, 0.0])  # from place to place, and all along at one
def test_places_have_the_unit_of_their_axis(kind: str, unit: str, size: float) -> None:
    joint = replace(TRUE.joints[0], kind=kind, name="X")
    slide = prepare(replace(TRUE, joints=(joint,), gravity=(0.0, 0.0)), [sines(3.0, seed=i, size=size) for i in (0, 1)])
    rows = sum(len(run.analysis_index) for run in slide.held)
    named = [region for family, region in found(slide, np.ones((rows, 1))) if family == "position"]
    assert len(named) == (6 if size else 1)
    assert {region.split()[-1] for region in named} == {unit}


def test_region_means_what_it_says(prepared: Prepared) -> None:
    signals = analysis_signals(prepared.held)
    masks = region_masks(prepared.held, 0, "revolute")
    speed = np.abs(signals["velocity"][:, 0])
    motion = masks["motion"]
    assert speed[motion["low velocity"]].max() <= speed[motion["medium velocity"]].min()
    assert speed[motion["medium velocity"]].max() <= speed[motion["high velocity"]].min()
    assert (signals["velocity"][masks["direction"]["forward"], 0] > 0.0).all()
    assert speed[motion["velocity reversal"]].mean() < speed.mean()
    load = np.abs(signals["command"][:, 0])
    assert load[masks["load"]["high load"]].min() >= load[masks["load"]["low load"]].max()


def test_times_are_those_of_the_recording() -> None:
    """Also where the last part of it is held out: that lies in its last third."""
    single = prepare(TRUE, [sines(9.0)])
    (held,) = single.held
    time = analysis_signals(single.held)["time"]
    assert time == pytest.approx(held.time[held.analysis_index])  # the record begins at 0 s
    assert 6.3 < time[0] < time[-1] < 9.0
    later = prepare(TRUE, [replace(sines(9.0), t=sines(9.0).t + 100.0)])
    assert analysis_signals(later.held)["time"] == pytest.approx(time)
    thirds = region_masks(single.held, 0, "revolute")["time"]
    assert list(thirds) == ["last third of a run"]
    for run in single.fit:
        masks = region_masks([run], 0, "revolute")["time"]
        assert list(masks) == ["first third of a run", "middle third of a run", "last third of a run"]
        seen = analysis_signals([run])["time"]
        assert [seen[mask].min() for mask in masks.values()] == pytest.approx([seen[0], 3.0, 6.0], abs=0.05)


def found(prepared: Prepared, before: np.ndarray, noise: float = 0.0) -> dict[tuple[str, str], tuple[float, ...]]:
    """Share with interval, time share and rms by family and region."""
    floor = np.full_like(before, noise)
    return {
        (r.family, r.region): (r.share.value, r.share.low, r.share.high, r.time_share, r.rms, r.rms_corrected)
        for r in regions(prepared, before, 0.5 * before, floor, 0)
    }


def test_share_is_where_it_was_put(prepared: Prepared) -> None:
    """A residual in one region only, on top of a floor that is taken off."""
    rng = np.random.default_rng(0)
    mask = motion_masks(prepared.held, 0)["high velocity"]
    noise = 0.1
    before = noise * rng.standard_normal((len(mask), 1)) + 2.0 * mask[:, None]
    rows = found(prepared, before, noise)
    share, low, high, time, rms, corrected = rows["motion", "high velocity"]
    assert share == pytest.approx(1.0, abs=0.02)
    assert low > 0.9
    assert high <= 1.0
    assert time == pytest.approx(mask.mean())
    assert rms == pytest.approx(2.0, abs=0.05)
    assert corrected == pytest.approx(0.5 * rms)
    assert rows["motion", "low velocity"][0] < 0.02


def test_even_residual_has_shares_of_time(prepared: Prepared) -> None:
    rows = sum(len(run.analysis_index) for run in prepared.held)
    shares = found(prepared, np.where(np.arange(rows) % 2, 1.0, -1.0)[:, None])
    for (family, _), (share, low, high, time, *_) in shares.items():
        if family != "frequency":
            assert share == pytest.approx(time, abs=1e-9)
            assert low <= share <= high


def test_of_less_than_the_noise_there_is_no_share(prepared: Prepared) -> None:
    """Nor an interval that leaves the value out."""
    rows = sum(len(run.analysis_index) for run in prepared.held)
    shares = found(prepared, 0.5 * np.random.default_rng(1).standard_normal((rows, 1)), 1.0)
    for (family, _), (share, low, high, *_) in shares.items():
        if family != "frequency":  # whose noise stays in
            assert (share, low) == (0.0, 0.0)
            assert high < 0.05


def test_places_share_the_whole_gap(prepared: Prepared) -> None:
    """An effect that takes in noise as well, and one that makes it worse, add up to no more than all of it."""
    rng, rows = np.random.default_rng(2), sum(len(run.analysis_index) for run in prepared.held)
    names = ("torque_gain", "presliding", "cogging")
    noise = np.full((rows, 1), 1.0)
    models: list[Any] = [SimpleNamespace(held=5.0 * rng.standard_normal((rows, 1)), placed=())]
    for name, size in zip(names, (2.0, 3.0, 0.5), strict=True):
        placed = (Placed(effect_named(name), 0),)
        models.append(SimpleNamespace(held=size * rng.standard_normal((rows, 1)), placed=placed))
    for count, shares in (
        (2, {"actuator": 21.0 / 24.0, "unknown": 3.0 / 24.0}),
        (3, {"actuator": 21.0 / 29.0, "unknown": 8.0 / 29.0}),  # bristles take nothing
        (4, {"actuator": 1.0}),  # what is left is less than the noise
    ):
        told = {}
        for place in places(prepared, models[:count], noise, {}, 0):
            assert place.share.low <= place.share.value <= place.share.high
            told[place.channel] = told.get(place.channel, 0.0) + place.share.value
        assert told == pytest.approx(shares, abs=0.05)
        assert sum(told.values()) == pytest.approx(1.0)


def test_an_effect_has_its_row_at_each_joint_at_which_it_is_named(two: Prepared) -> None:
    """Also where another joint's gap, in floors, is far larger; but not where it bends others' torque a little."""
    rows = sum(len(run.analysis_index) for run in two.held)
    signs = np.where(np.arange(rows) % 2, 1.0, -1.0)[:, None]
    sizes = ((9.0, 100.0), (8.9, 1.0), (1.0, 1.0))  # floors, of A and of B
    placed = [Placed(effect_named("cogging"), joint) for joint in (1, 0)]
    models: list[Any] = [
        SimpleNamespace(held=signs * np.array(size), placed=placed[:k]) for k, size in enumerate(sizes)
    ]
    alike = {("cogging", "A"): ("cogging",), ("cogging", "B"): ("cogging", "cable_spring")}
    told = places(two, models, np.ones((rows, 2)), alike, 0)
    assert [(place.joint, place.channel) for place in told] == [("B", "actuator"), ("A", "actuator")]
    assert [place.channels for place in told] == [("actuator", "external"), ("actuator",)]
    assert told[1].share.value == pytest.approx((8.9**2 - 1.0) / (100.0**2 + 9.0**2 - 2.0))


def test_a_share_may_lie_in_the_stage_of_any_effect_that_looks_alike(prepared: Prepared) -> None:
    rows = sum(len(run.analysis_index) for run in prepared.held)
    placed = (Placed(effect_named("torque_offset"), 0),)
    models: list[Any] = [SimpleNamespace(held=np.full((rows, 1), size), placed=placed) for size in (5.0, 2.0)]
    alike = {("torque_offset", "A"): ("torque_offset", "gravity_tilt", "asymmetric_friction", "cogging")}
    told, left = places(prepared, models, np.full((rows, 1), 1.0), alike, 0)
    assert (told.channel, told.channels) == ("actuator", ("actuator", "rigid_body", "friction"))
    assert (left.channel, left.channels) == ("unknown", ("unknown",))


def test_shares_of_a_family_sum_to_one(prepared: Prepared) -> None:
    rows = sum(len(run.analysis_index) for run in prepared.held)
    shares = found(prepared, np.random.default_rng(1).standard_normal((rows, 1)))
    for family in {family for family, _ in shares}:
        assert sum(row[0] for key, row in shares.items() if key[0] == family) == pytest.approx(1.0)


def test_what_one_place_has_is_told_of_that_place(prepared: Prepared) -> None:
    """As a stop is, though the joint turns there; what speed has is told of the speed."""
    families = region_masks(prepared.held, 0, "revolute")
    for family, region in (("position", list(families["position"])[-1]), ("motion", "high velocity")):
        part = np.where(families[family][region], 4.0, 0.01)
        assert _region(prepared, 0, part) == region
    assert _region(prepared, 0, np.zeros(len(part))) == "all motion"


def test_a_part_below_its_noise_takes_nothing_from_the_others(prepared: Prepared) -> None:
    rows = sum(len(run.analysis_index) for run in prepared.held)
    masks = motion_masks(prepared.held, 0)
    before = np.full((rows, 1), 2.0)
    before[masks["low velocity"]] = 0.3
    shares = found(prepared, before, 1.0)
    assert shares["motion", "low velocity"][:3] == (0.0, 0.0, 0.0)
    for family in {family for family, _ in shares}:
        assert sum(row[0] for key, row in shares.items() if key[0] == family) == pytest.approx(1.0)
        assert all(row[1] <= row[0] <= row[2] <= 1.0 for key, row in shares.items() if key[0] == family)


def test_frequency_band_of_a_sine(prepared: Prepared) -> None:
    """A residual of half the analysis cutoff lies in the highest band, a slow one in the lowest; power is kept."""
    time = analysis_signals(prepared.held)["time"]
    for hertz, place in ((0.5 * prepared.cutoff, 2), (0.06 * prepared.cutoff, 0)):
        rows = found(prepared, np.sin(2 * np.pi * hertz * time)[:, None])
        bands = [row for (family, _), row in rows.items() if family == "frequency"]
        assert bands[place][0] > 0.9
        assert np.sqrt(sum(row[4] ** 2 for row in bands)) == pytest.approx(np.sqrt(0.5), rel=0.05)


def test_the_interval_of_a_band_tells_how_far_blocks_agree(prepared: Prepared) -> None:
    """A burst of fast torque in one tenth of the run may have been anywhere; all along, it is sure."""
    time = analysis_signals(prepared.held)["time"]
    slow, fast = (np.sin(2 * np.pi * part * prepared.cutoff * time)[:, None] for part in (0.06, 0.5))
    burst = fast * (np.arange(len(time)) < len(time) / 10)[:, None]
    widths = []
    for residual in (slow + fast, slow + 3.0 * burst):
        share, low, high, *_ = [row for (family, _), row in found(prepared, residual).items() if family == "frequency"][
            2
        ]
        assert low < share < high
        widths.append(high - low)
    assert widths[0] < 0.15 < 0.3 < widths[1]
