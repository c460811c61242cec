"""What is chosen and thinned for drawing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stribeck.report.signals import telling_family, telling_window, thin, with_breaks


def test_window_lies_where_retuning_leaves_most(diagnosis):
    made = diagnosis("no_gap", duration=20.0)
    worst = made.traces[1]
    bump = np.where((worst.time > 11.0) & (worst.time < 12.0), 5.0, 0.0)[:, None]
    made = replace(made, traces=(made.traces[0], replace(worst, measured=worst.measured + bump)))
    trace, part = telling_window(made)
    time = trace.time[part]
    assert trace.run == worst.run
    assert 2.8 <= time[-1] - time[0] <= 3.1
    assert time[0] < 10.7  # the event is inside, not at the edge
    assert time[-1] > 12.3


def test_window_of_a_short_run_is_the_run(diagnosis):
    made = diagnosis(duration=1.0)
    trace, part = telling_window(made)
    assert len(trace.time[part]) == len(trace.time)


def test_thinning_keeps_the_outline_and_the_gaps():
    time = np.arange(100_000) / 1000.0
    values = np.sin(time)
    values[54_321] = 9.0
    short_time, short = thin(time, values)
    assert len(short) <= 3000
    assert short.max() == 9.0
    assert abs(short_time[np.argmax(short)] - 54.321) < 0.1
    time[50_000:] += 10.0
    broken_time, broken = with_breaks(time, values)
    assert np.isnan(broken).sum() == 1
    assert broken_time[50_000] == time[49_999]


def test_family_is_position_where_position_tells_more(diagnosis):
    made = diagnosis()
    assert telling_family(made) == "velocity"
    regions = tuple(r for r in made.regions if r.family not in ("motion", "direction"))
    assert telling_family(replace(made, regions=regions)) == "position"
