"""The public names: each there, listed once, and none imported before it is asked for."""

import subprocess
import sys

import pytest

import stribeck
import stribeck.effects
from stribeck.effects import Effect


def test_every_public_name_is_there() -> None:
    assert len(set(stribeck.__all__)) == len(stribeck.__all__)
    for name in stribeck.__all__:
        assert getattr(stribeck, name).__module__.startswith("stribeck.")
        assert name in dir(stribeck)


def test_another_name_is_refused() -> None:
    with pytest.raises(AttributeError, match="no attribute 'lubricate'"):
        _ = stribeck.lubricate


def test_nothing_is_imported_early() -> None:
    """The command's first word is not to wait for CasADi."""
    code = "import sys, stribeck; print([m for m in sys.modules if m.split('.')[0] in ('casadi', 'numpy', 'control')])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"


def test_an_effect_needs_no_other_import() -> None:
    """Every stage of the path can be subclassed with what the library of effects exports."""
    stages = {cls for cls in Effect.__subclasses__() if cls.__module__ == Effect.__module__}
    assert stages <= {getattr(stribeck.effects, name) for name in stribeck.effects.__all__}
