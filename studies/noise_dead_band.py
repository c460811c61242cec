"""Question: what does encoder noise do to a loop that would rest? Over-compensated, it cycles; a dead-band stops it.

Method: joint A at 80 Hz, Kp 30, critical damping, finite-difference velocity, encoder noise 20 urad, compensation
k = 1.3 with none at velocity zero: event-driven simulation of 200 s at each dead-band, in units of the velocity's
standard deviation sqrt(2) 20 urad / 12.5 ms; the settled cycle and its basin without, and with 5 of them.
Expected: noise-free it rests; with noise it cycles at 60.9 mrad and 3.8 s, since noise makes sgn(0) a fair coin, and
the critical ratio 1; a dead-band of 4.4 standard deviations or more lets it rest.
Source: paper, 4.3.2; Canudas de Wit et al. 1991.
"""

from __future__ import annotations

import math
from dataclasses import replace

import typer
from _cycles import branches_figure, joint, loop
from _output import write
from _single import amplitude

from stribeck.loop.exact.settle import settle
from stribeck.loop.exact.shooting import shoot
from stribeck.simulate import Loop, close_loop

SAMPLE, NOISE = 0.0125, 2e-5
SIGMA = math.sqrt(2.0) * NOISE / SAMPLE  # rad/s
BANDS = (0.0, 1.0, 2.0, 3.0, 3.5, 4.0, 4.4, 5.0, 6.0)


def with_band(band: float, noise: float = NOISE) -> Loop:
    """Return the loop with a dead-band of so many standard deviations of the velocity."""
    plain = loop(1.3, "zero", sample_time=SAMPLE, encoder_noise=noise)
    entry = plain.joints[0]
    law = replace(entry.compensation, dead_band=band * SIGMA)
    return replace(plain, duration=200.0, joints=(replace(entry, compensation=law),))


def main() -> None:
    """Simulate each dead-band; write the answers and the figure."""
    sizes = [1e3 * amplitude(close_loop(joint("A"), with_band(band))) for band in BANDS]
    noisy, calm = (settle(joint("A"), with_band(band))["A"] for band in (0.0, 5.0))
    quiet = shoot(joint("A"), with_band(0.0, noise=0.0))["A"]
    result = {
        "units": {"amplitude": "rad", "period": "s", "dead_band": "standard deviations of the velocity"},
        "without_noise": quiet.verdict,
        "with_noise": {"verdict": noisy.verdict, "amplitude": noisy.amplitude, "period": noisy.period},
        "with_dead_band_5": calm.verdict,
        "dead_band": [{"band": band, "amplitude": 1e-3 * size} for band, size in zip(BANDS, sizes, strict=True)],
    }
    panels = {
        "k = 1.3 at critical damping, 20 µrad of encoder noise": (
            "dead-band, standard deviations of the velocity", "amplitude, mrad", {"simulated": (BANDS, sizes)}, {})
    }  # fmt: skip
    figure = branches_figure(
        panels, "Noise starts the cycle that a noise-free loop does not have; a dead-band stops it"
    )
    print(f"written to {write('noise_dead_band', result, dead_band=figure)}")


if __name__ == "__main__":
    typer.run(main)
