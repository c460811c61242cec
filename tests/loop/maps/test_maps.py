"""Maps: their own kernel against the event-driven reference, cost, chunks, backends, bad input."""

import math
import time
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import EffectEntry, Friction
from stribeck.errors import InputError
from stribeck.loop.cycle import CYCLES, VERDICTS
from stribeck.loop.exact.rounds import Rounds
from stribeck.loop.maps import label as label_module
from stribeck.loop.maps import label_map
from stribeck.loop.maps.cells import cells_of, template_of
from stribeck.loop.maps.grid import Axes, loop_of_cell
from stribeck.loop.watched import watched
from stribeck.simulate import Reference, simulate_loop
from stribeck.simulate.axis import start_position

RATIOS = (0.8, 1.2, 1.7)
GAINS = (15.0, 80.0)
DAMPING = (0.2, 0.6)
LIGHT = Friction(2.2, 0.6, 0.8, 0.04)
FAMILIES = {
    "set-valued": ({"at_zero": "set_valued"}, {"k": RATIOS, "kp": GAINS, "zeta": DAMPING}),
    "hold": ({"at_zero": "hold"}, {"k": RATIOS, "kp": GAINS, "zeta": DAMPING}),
    "hold, dead-band": ({"at_zero": "hold"}, {"k": (1.2, 1.7), "zeta": DAMPING, "dead_band": (0.1, 0.4)}),
    "hold, filter": ({"at_zero": "hold"}, {"k": (1.2, 1.7), "zeta": DAMPING, "velocity_filter": (0.05,)}),
    "zero, lag": ({"at_zero": "zero", "actuator_lag": 0.01}, {"k": RATIOS, "kp": GAINS, "zeta": DAMPING}),
    "PID": ({"at_zero": "zero", "ki": 30.0}, {"k": RATIOS[:2], "zeta": DAMPING}),
    "ramp": ({"kind": "feedforward", "velocity": 0.02}, {"velocity": (0.005, 0.02, 0.06), "zeta": DAMPING}),
    "backward ramp": ({"kind": "none", "velocity": -0.02}, {"kp": GAINS, "zeta": DAMPING}),
    "sampled, filter": (
        {"at_zero": "zero", "sample_time": 0.0125, "velocity_filter": 0.01},
        {"k": (1.2, 2.0), "zeta": (0.2, 0.6), "delay": (0, 2)},
    ),
    "sampled, filter, set-valued": (
        {"at_zero": "set_valued", "sample_time": 0.0125, "velocity_filter": 0.3},
        {"k": (0.8, 1.2)},
    ),
    "sampled, filter, error sign": (
        {"at_zero": "error_sign", "sample_time": 0.0125, "velocity_filter": 0.05},
        {"k": (0.8, 1.2)},
    ),
}


@pytest.mark.parametrize("family", FAMILIES)
def test_labels_are_those_of_the_events(arm, loop_of, family):
    settings, axes = FAMILIES[family]
    loop = loop_of(**settings)
    fast = label_map(arm, loop, "A", axes)
    exact = label_map(arm, loop, "A", axes, method="events")
    assert (fast.method, exact.method) == ("cells", "events")
    assert fast.codes.shape == tuple(len(values) for values in axes.values())
    assert (fast.verdicts == exact.verdicts).all()
    cycles = np.isfinite(exact.amplitude)
    assert cycles.any()
    assert (np.isfinite(fast.amplitude) == cycles).all()
    close = 0.01 if loop.sample_time else 3e-3
    assert np.abs(fast.amplitude / exact.amplitude - 1.0)[cycles].max() < close
    assert np.abs(fast.period / exact.period - 1.0)[cycles].max() < close


SCALED = {  # loop settings, axes
    "set-valued": ({}, {"k": (0.9, 1.02, 1.2), "kp": (18.0, 50.0), "kv": (4.0, 8.0)}),
    "PID": ({"kind": "none", "ki": 10.0}, {"kp": (30.0, 50.0), "kv": (6.0, 11.0)}),
    "ramp": ({"kind": "none", "velocity": 0.01}, {"velocity": (0.001, 0.01, 0.1), "kp": (10.0, 80.0), "kv": (3.0,)}),
}


@pytest.mark.parametrize("family", SCALED)
@pytest.mark.parametrize(("length", "period"), [(1e-3, 1.0), (1.0, 30.0)], ids=["small", "slow"])
def test_a_small_or_a_slow_joint_has_the_map_of_any_other(arm, loop_of, family, length, period):
    """The same equations in other units: a linear axis that moves by micrometres, or a joint that creeps."""
    settings, axes = SCALED[family]
    units = {"k": 1.0, "kp": 1.0 / length, "kv": period / length, "velocity": length / period}
    own, f = arm.joints[0], arm.joints[0].friction
    friction = Friction(f.C0, f.C1, f.C2 * period / length, f.alpha * length / period)
    inertia = period**2 / length - 1e-9
    joint = replace(own, mass=1e-9, inertia=1e-9, rotor_inertia=inertia, friction=friction, backward=friction)
    loop = loop_of(**settings)
    entry = loop.joints[0]
    goal = entry.reference
    reference = replace(goal, initial_error=goal.initial_error * length, velocity=goal.velocity * length / period)
    entry = replace(entry, kp=entry.kp / length, ki=entry.ki / (length * period), reference=reference)
    scaled = {name: tuple(value * units[name] for value in values) for name, values in axes.items()}
    there = label_map(replace(arm, joints=(joint,)), replace(loop, joints=(entry,)), "A", scaled)
    here = label_map(arm, loop, "A", axes)
    assert (there.verdicts == here.verdicts).all()
    cycles = np.isfinite(here.amplitude)
    assert cycles.any()
    assert np.abs(there.amplitude / length / here.amplitude - 1.0)[cycles].max() < 1e-3
    assert np.abs(there.period / period / here.period - 1.0)[cycles].max() < 1e-3


def test_amplitude_follows_the_coth_law(arm, loop_of):
    """Coulomb friction by a bend so narrow that it does not matter."""
    joint = arm.joints[0]
    friction = replace(joint.friction, C1=0.0, C2=0.0)
    coulomb = replace(arm, joints=(replace(joint, friction=friction, backward=friction),))
    ratio, zeta = np.array([1.1, 1.3]), np.array([0.1, 0.5, 0.9, 0.99])
    found = label_map(coulomb, loop_of(), "A", {"k": ratio, "zeta": zeta})
    root = np.sqrt(1.0 - zeta**2)
    law = (ratio[:, None] - 1.0) * 5.0 / 30.0 / np.tanh(math.pi * zeta / (2.0 * root))
    assert np.abs(found.amplitude / law - 1.0).max() < 2e-3
    assert np.abs(found.period / (2.0 * math.pi / (math.sqrt(30.0) * root)) - 1.0).max() < 2e-3


def test_a_map_of_101_by_50_takes_three_seconds(arm, loop_of):
    """Of the processor, whatever else the machine does; and the cost is that of the cells."""
    axes = {"k": np.linspace(0.5, 2.0, 101), "kp": np.linspace(10.0, 100.0, 50)}
    loop = loop_of()
    label_map(arm, loop, "A", {"k": (1.0,)})
    begin = time.process_time()
    whole = label_map(arm, loop, "A", axes)
    spent = time.process_time() - begin
    assert spent < 6.0  # two cores for 3 s
    assert np.mean(whole.verdicts == "undetermined") <= 0.01
    begin = time.process_time()
    label_map(arm, loop, "A", {**axes, "kp": axes["kp"][::5]})
    assert time.process_time() - begin == pytest.approx(spent / 5.0, rel=0.6)


MAP = {"k": np.linspace(0.5, 2.0, 101), "kp": np.linspace(10.0, 100.0, 50), "zeta": (0.5,)}
ATLAS = {"k": np.linspace(0.5, 2.0, 15), "kp": np.geomspace(10.0, 100.0, 8), "zeta": np.linspace(0.1, 1.2, 8),
         "delay": np.arange(5.0)}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rule", "sample_time", "axes"),
    [("set_valued", 0.0, MAP), ("hold", 0.0, MAP), ("zero", 0.0125, ATLAS), ("set_valued", 0.0125, ATLAS)],
)
def test_labels_of_large_maps_are_those_of_the_events(arm, loop_of, rule, sample_time, axes):
    """Random cells of a whole map, and of an atlas over k, Kp, zeta and delay.

    Where shooting and map differ, a plain event-driven simulation of 400 s decides whether there is a cycle.
    """
    loop = loop_of(rule, sample_time=sample_time)
    begin = time.process_time()
    fast = label_map(arm, loop, "A", axes)
    assert (time.process_time() - begin) / fast.codes.size < 600e-6  # a million on two cores within 5 min
    assert np.mean(fast.verdicts == "undetermined") <= 0.002
    rng, wrong, count = np.random.default_rng(11), 0, 100
    for place in zip(*(rng.integers(0, size, count) for size in fast.codes.shape), strict=True):
        cell = {name: (values[i],) for (name, values), i in zip(axes.items(), place, strict=True)}
        exact = label_map(arm, loop, "A", cell, method="events", jobs=1)
        if exact.codes.item() != fast.codes[place]:
            wrong += fast.verdicts[place] not in CYCLES or not seen_to_cycle(arm, loop, cell, fast.amplitude[place])
    assert wrong <= 0.01 * count


def seen_to_cycle(arm, loop, cell, amplitude):
    """Whether a simulation cycles, by that amplitude."""
    one = loop_of_cell(loop, loop.joints[0], 1.0, {name: values[0] for name, values in cell.items()})
    seen = watched(simulate_loop(arm, replace(one, duration=400.0)), 0)
    return not isinstance(seen, str) and seen[0] == pytest.approx(amplitude, rel=0.01)


@pytest.mark.slow
def test_an_atlas_costs_by_the_cell_and_holds_little_beside_itself(arm, loop_of):
    """Eight times the cells in as much more time, and of memory no more than the map's own 13 bytes a cell."""
    loop, spent, held = loop_of("set_valued", sample_time=0.0125), [], []
    label_map(arm, loop, "A", {"k": (1.0,)})
    for across in (10, 80):
        axes = {**ATLAS, "k": np.linspace(0.5, 2.0, across)}
        tracemalloc.start()
        begin = time.process_time()
        found = label_map(arm, loop, "A", axes)
        spent.append(time.process_time() - begin)
        held.append((tracemalloc.get_traced_memory()[1] - 13 * found.codes.size) / 1e6)
        tracemalloc.stop()
    assert spent[1] / spent[0] == pytest.approx(8.0, rel=0.4)
    assert held[1] < max(2.0 * held[0], 4.0)  # MB


@pytest.mark.parametrize(("ki", "verdict"), [(8.0, "rest"), (60.0, "rest"), (600.0, "hunting")])
def test_a_sampled_integral_that_creeps_to_rest_is_known_to(arm, loop_of, ki, verdict):
    """Slip by slip, each a part of the one before, as the events say."""
    bent = Friction(0.8, 0.5, 0.3, 0.05)
    joint = replace(arm.joints[0], rotor_inertia=0.1, inertia=0.17, friction=bent, backward=bent)
    given = loop_of(sample_time=0.002, kind="none", kv=6.0, ki=ki)
    found = label_map(replace(arm, joints=(joint,)), given, "A", {"kp": (60.0,)})
    assert found.verdicts.tolist() == [verdict]


def test_what_once_had_no_label(arm, loop_of):
    """A creep that ends where the joint just holds, and a joint that turns many times where it stops."""
    light = replace(arm.joints[0], rotor_inertia=0.0, inertia=0.1416, friction=LIGHT, backward=LIGHT)
    slow = loop_of(kv=1.5)
    slow = replace(slow, joints=(replace(slow.joints[0], reference=Reference("regulate", initial_error=-0.3)),))
    ratios, gains = np.linspace(0.95, 0.999, 60), np.linspace(2.8, 3.6, 20)
    found = label_map(replace(arm, joints=(light,)), slow, "A", {"k": ratios, "kp": gains})
    assert (found.verdicts == "rest").all()
    late = loop_of("set_valued", sample_time=0.0125)
    cell = {"k": (1.2346938775510203,), "kp": (27.28333376486768,), "zeta": (0.8666666666666666,), "delay": (4,)}
    assert label_map(arm, late, "A", cell).verdicts.item() == "sliding_cycle"


def test_chunks_and_backends_do_not_matter(arm, loop_of, monkeypatch):
    axes = {"k": np.linspace(0.8, 1.6, 7), "zeta": np.linspace(0.2, 0.9, 5)}
    whole = label_map(arm, loop_of(), "A", axes)
    monkeypatch.setattr(label_module, "_CHUNK", 4)
    monkeypatch.setattr(label_module, "_AT_ONCE", 3)
    for backend in ("joblib", "dask"):
        parts = label_map(arm, loop_of(), "A", axes, backend=backend)
        assert (parts.codes == whole.codes).all()
        np.testing.assert_array_equal(parts.amplitude, whole.amplitude)


def test_how_far_a_map_is_gets_told(arm, loop_of, monkeypatch):
    monkeypatch.setattr(label_module, "_CHUNK", 10)
    monkeypatch.setattr(label_module, "EVERY", 0.0)
    shares = []
    label_map(arm, loop_of(), "A", {"k": np.linspace(0.8, 1.6, 40)}, told=shares.append)
    assert shares == [0.25, 0.5, 0.75]


def test_the_error_of_a_loop_that_regulates_is_no_ramps(arm, loop_of):
    """A ramp starts where the joint is, whatever the key says: the kernel and the events as the simulation."""
    (entry,) = loop_of(velocity=0.02).joints
    misread = Reference("ramp", velocity=0.02, initial_error=0.4)
    loop = replace(loop_of(velocity=0.02), joints=(replace(entry, reference=misread, start=0.1),))
    assert start_position(arm, loop) == pytest.approx([0.1])
    template = template_of(Rounds(arm, loop), "A")
    own = cells_of(template, Axes(("k",), (np.ones(1),)), 0, 1)["starts"][0, :2]
    assert own == pytest.approx([0.0, 0.0])
    assert template_of(Rounds(arm, loop_of()), "A").error == 0.5


def test_what_the_kernel_cannot_take_is_labelled_by_events(arm, loop_of):
    effect = EffectEntry("torque_gain", ("A",), {"A": {"gain": 0.9}})
    found = label_map(replace(arm, effects=(effect,)), loop_of(), "A", {"k": (1.4,), "zeta": (0.3,)})
    assert (found.method, found.why) == ("events", "the arm has effects")
    assert found.verdicts.item() == "sliding_cycle"


def test_what_has_no_exact_cycle_is_labelled_by_what_it_settles_on(arm, loop_of):
    """Under an encoder's noise nothing repeats; what it does without is what it does with a little."""
    loop = loop_of(sample_time=0.0125)
    noisy = replace(loop, joints=(replace(loop.joints[0], encoder_noise=1e-6),))
    axes = {"k": (0.5, 1.5)}
    found, quiet = (label_map(arm, each, "A", axes) for each in (noisy, loop))
    assert found.method == "events"
    assert (found.verdicts == quiet.verdicts).all()
    assert found.amplitude == pytest.approx(quiet.amplitude, rel=0.02, nan_ok=True)


def test_unstable_gains_and_delays_over_the_period_are_labelled(arm, loop_of):
    loop = loop_of("zero", sample_time=0.0125)
    found = label_map(arm, loop, "A", {"kp": (30.0, 5000.0), "delay": (0, 200)})
    assert set(found.verdicts.ravel()) <= set(VERDICTS)
    assert found.verdicts[1, 0] == "unbounded"
    assert found.verdicts[0, 1] == "unbounded"


@pytest.mark.parametrize(
    ("axes", "settings", "text"),
    [
        ({}, {}, "the map has no axis"),
        ({"k": ()}, {}, "the map's axis k is empty"),
        ({"k": (-0.1,)}, {}, "the map's axis k is out of range: found -0.1"),
        ({"kp": (0.0,)}, {}, "the map's axis kp is out of range: found 0"),
        ({"kp": (float("nan"),)}, {}, "the map's axis kp is out of range"),
        ({"gain": (1.0,)}, {}, "the map has no such axis: found 'gain'"),
        ({"delay": (1,)}, {}, "a delay in samples needs a sampled controller"),
        ({"delay": (0.5,)}, {"sample_time": 0.0125}, "the map's axis delay is out of range: found 0.5"),
        ({"kv": (1.0,), "zeta": (1.0,)}, {}, "the map varies kv and zeta"),
    ],
)
def test_bad_axes_are_one_line(arm, loop_of, axes, settings, text):
    with pytest.raises(InputError) as caught:
        label_map(arm, loop_of(**settings), "A", axes)
    assert str(caught.value).startswith(text)
    assert "\n" not in str(caught.value)


def test_a_joint_that_is_not_controlled_is_refused(arm, loop_of):
    with pytest.raises(InputError, match="does not control"):
        label_map(arm, loop_of(), "Z", {"k": (1.0,)})
