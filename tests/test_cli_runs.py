"""The runs that a command is given: each goes by a name of its own, and none is given twice."""

from pathlib import Path

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.cli.shared import load_runs
from stribeck.errors import InputError
from stribeck.run import Run, save_run

FRICTION = Friction(1.0, 0.0, 0.5, 0.05)
ARM = Arm("one", (0.0, 0.0), (Joint("A", "revolute", 0.3, 1.0, (0.1, 0.0), 0.01, 0.0, FRICTION, FRICTION),))


def recording(path: Path, seed: int) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    values = np.random.default_rng(seed).normal(size=(20, 2))
    save_run(Run(path.name, np.arange(20) / 100.0, values[:, :1], values[:, 1:]), path)
    return path


def test_files_of_one_name_go_by_their_folders(tmp_path: Path) -> None:
    names = ("monday/a/run.csv", "tuesday/a/run.csv", "tuesday/b/run.csv", "tuesday/other.csv")
    paths = [recording(tmp_path / name, seed) for seed, name in enumerate(names)]
    fitted, held = load_runs(ARM, paths[:2], paths[2:])
    assert [run.name for run in fitted] == ["monday/a/run.csv", "tuesday/a/run.csv"]
    assert [run.name for run in held] == ["b/run.csv", "other.csv"]


def test_two_files_of_the_same_samples_are_one_run(tmp_path: Path) -> None:
    """A run that is held out under another name judges a fit by its own data."""
    paths = [recording(tmp_path / name, seed) for name, seed in (("a.csv", 0), ("b.csv", 1), ("c.parquet", 0))]
    assert len(load_runs(ARM, paths[:2], ())[0]) == 2
    with pytest.raises(InputError, match=r"^a run is given twice: found .*a.csv and "):
        load_runs(ARM, paths[:2], paths[2:])
