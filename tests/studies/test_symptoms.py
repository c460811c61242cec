"""What the pictures of the symptoms show is there: the effect's residual, and the law that takes it."""

import importlib
import struct

import pytest

from stribeck.effects.registry import registry

OWN = [name for name, effect in registry().items() if type(effect).__module__.startswith("stribeck.effects.")]
SAMPLE = ("cogging",)  # all of them take a minute
USUAL = (3.0, 0.5)  # of the variance: with over without, and left over with
LIMITS = {
    "encoder_eccentricity": (1.1, 0.7),  # a disc runs out of centre by little, and re-tuning takes most of that
    "encoder_quantisation": (3.0, 0.7),  # a step that comes a little late leaves all of its height
}


@pytest.mark.long
@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n in SAMPLE else pytest.mark.slow) for n in OWN])
def test_a_symptom_is_seen_and_the_law_explains_it(name):
    cases, signals, figure = (importlib.import_module(f"_symptom_{part}") for part in ("cases", "signals", "figure"))
    effect = registry()[name]
    case = cases.case_of(effect)
    symptom = signals.symptom_of(effect, case)
    rms = signals.sizes(case, symptom)
    seen, left = LIMITS.get(name, USUAL)
    assert rms["with"] ** 2 > seen * rms["without"] ** 2
    assert rms["left"] ** 2 < left * rms["with"] ** 2
    picture = figure.small_png(figure.symptom_figure(effect, symptom))
    assert len(picture) < 40_000
    width, height = struct.unpack(">II", picture[16:24])
    assert 600 <= width <= 800
    assert 200 <= height <= 400
