"""Question: how large may Kp be before a sampled loop turns unstable or fragile? Every sample of delay costs half.

Method: one joint of 1 kg m^2, friction left out, for it helps only where it is; critical damping, Kv = 2 sqrt(Kp), at
80 Hz with velocity by finite difference; hold, delay and lag by exact discretisation. The largest Kp by stability and
by a sensitivity peak Ms of at most 2. Simulation at 0.98 and 1.02 of the limit, almost without friction, checks it.
Expected: 3150 and 655 without delay, 662 and 150 with one sample, 290 and 66 with two, 283 and 57 with one and 20 ms of
lag: Kp = 60 of the paper stands at the edge for two samples of delay. Found 282.5 and 56.5 for the last.
Source: the project's own acceptance figures; Åström & Wittenmark (1997); Åström & Hägglund (2006) for Ms.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import typer
from _cycles import joint
from _output import write
from matplotlib.figure import Figure
from rich import print as show

from stribeck.loop.linear import assemble, free, kp_max, margins
from stribeck.report.figures.log_ticks import plain_log
from stribeck.report.style import COLOUR, drawn, grid, heading, new_figure
from stribeck.simulate import JointLoop, Loop, Reference, close_loop

CASES = {"no delay": (0, 0.0), "1 sample": (1, 0.0), "2 samples": (2, 0.0), "1 sample, lag 20 ms": (1, 0.02)}

LABELS = {"no delay": 4.0, "1 sample": 5.0, "2 samples": 12.0, "1 sample, lag 20 ms": 6.0}  # at which Ms each is named


def main(cases: int = 24) -> None:
    """Find the largest gains; ``--cases N`` draws Ms at 2 N gains."""
    result, curves = {}, {}
    for name, (delay, lag) in CASES.items():
        loop = Loop(0.0125, 20.0, (JointLoop("A", 60.0, Reference("regulate"), delay_samples=delay, actuator_lag=lag),))
        linear = assemble(joint("A").arm, loop, free(joint("A").arm, loop))
        top = kp_max(linear, "A")
        assert top.stability is not None
        grows = [growth(loop, factor * top.stability) for factor in (0.98, 1.02)]
        result[name] = {"stability": top.stability, "ms2": top.ms2, "ms_at_60": margins(linear, "A").sensitivity_peak,
                        "decays_below": grows[0] < 1.0, "grows_above": grows[1] > 1.0}  # fmt: skip
        near = top.stability * (1.0 - np.geomspace(0.5, 0.04, cases))  # where Ms bends upwards
        gains = np.union1d(np.geomspace(5.0, 0.5 * top.stability, cases), near)
        curves[name] = gains, np.array([margins(linear, "A", kp).sensitivity_peak for kp in gains])
    show(result)
    print(f"written to {write('gains', result, sensitivity=draw(curves))}")


def growth(loop: Loop, kp: float) -> float:
    """Return by how much the error grows over the last seconds of a simulation almost without friction."""
    engine, own = joint("Coulomb"), loop.joints[0]
    level = [entry.key.endswith(".C0") for entry in engine.path.entries]
    entry = replace(own, kp=kp, reference=Reference("regulate", initial_error=1e-3))
    error = np.abs(close_loop(engine, Loop(0.0125, 8.0, (entry,)), p=np.where(level, 1e-9, engine.p)).error[:, 0])
    return float(error[-80:].max() / error[240:320].max()) if np.isfinite(error).all() else np.inf


@drawn
def draw(curves: dict[str, tuple[np.ndarray, np.ndarray]]) -> Figure:
    """Draw Ms against Kp for each delay."""
    figure = new_figure(4.0)
    ax = figure.add_subplot()
    colours = [COLOUR[name] for name in ("corrected", "partner", "as_given", "retuned")]
    for (gains, peak), colour in zip(curves.values(), colours, strict=True):
        ax.loglog(gains, peak, color=colour, linewidth=1.5)
    ax.axhline(2.0, color=COLOUR["measured"], linewidth=0.8)
    ax.set(xlabel="Kp / J, 1/s²", ylabel="sensitivity peak Ms", xlim=(5.0, 3200.0), ylim=(1.0, 20.0))
    for axis in (ax.xaxis, ax.yaxis):
        plain_log(axis)
    for (name, (gains, peak)), colour in zip(curves.items(), colours, strict=True):
        at, high = np.interp(LABELS[name], peak, gains), LABELS[name]
        ax.annotate(f"{name} ", (at, high), color=colour, fontsize=9, fontweight="bold", ha="right", va="bottom")
    grid(ax, "both")
    heading(figure, "Each sample of delay costs a factor of two to four in Kp at Ms = 2")
    return figure


if __name__ == "__main__":
    typer.run(main)
