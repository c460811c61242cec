"""The picture of an effect's symptom, beside the effect's own file."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import pytest

import stribeck.effects
from stribeck.effects.actuator.torque_offset import TorqueOffset
from stribeck.effects.registry import laws, registry
from stribeck.report.symptom import picture_file, symptom_picture

OWN = [effect for effect in registry().values() if type(effect).__module__.startswith("stribeck.effects.")]
HOME = Path(stribeck.effects.__file__).parent


@pytest.mark.parametrize("effect", [pytest.param(effect, id=effect.name) for effect in OWN])
def test_every_effect_of_the_library_has_a_small_legible_picture(effect):
    file = picture_file(effect)
    assert file.stat().st_size < 40_000
    height, width, _ = matplotlib.image.imread(file).shape
    assert 600 <= width <= 800
    assert 200 <= height <= 400


def test_all_pictures_together_are_small_and_none_is_left_over():
    files = {picture_file(effect) for effect in OWN}
    assert set(HOME.rglob("*.png")) == files
    assert sum(file.stat().st_size for file in files) < 1_000_000


def test_all_laws_of_a_family_share_its_picture():
    names = {effect.name for effect in OWN}
    for effect in laws().values():
        assert symptom_picture(effect).startswith("data:image/png;base64,") == (effect.name in names)


def test_an_effect_without_a_picture_has_none():
    class Bare(TorqueOffset):
        name = "bare"

    assert symptom_picture(Bare()) == ""
