"""FMUs that several tests share, for the machine's own platform, built once a session."""

from collections.abc import Callable
from pathlib import Path

import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint
from stribeck.export import export_fmu
from stribeck.simulate import Engine, path_of

from .driver import Fmu

A = Friction(5.0, 1.25, 1.5, 0.05)
B = Friction(2.2, 0.6, 0.8, 0.04)


def two_links(*effects: EffectEntry, gravity: tuple[float, float] = (0.0, 0.0)) -> Arm:
    """The direct-drive arm of the paper, joints A and B."""
    joints = (
        Joint("A", "revolute", 0.35, 4.0, (0.17, 0.02), 0.06, 0.15, A, A),
        Joint("B", "revolute", 0.26, 2.0, (0.13, -0.01), 0.02, 0.08, B, B),
    )
    return Arm("two links", gravity, joints, effects=tuple(effects))


@pytest.fixture(scope="session")
def engine(_own_cache: None) -> Engine:
    return Engine(path_of(two_links()))


@pytest.fixture(scope="session")
def made(_own_cache: None, tmp_path_factory: pytest.TempPathFactory) -> Callable[[Arm, int], Path]:
    """Export an arm for this machine, each once."""
    folder, known = tmp_path_factory.mktemp("fmus"), dict[tuple[str, int], Path]()

    def make(arm: Arm, fmi: int) -> Path:
        key = (repr(arm), fmi)
        if key not in known:
            known[key] = folder / f"{len(known)}.fmu"
            export_fmu(arm, known[key], fmi=fmi, platforms=["x86_64-linux"])
        return known[key]

    return make


@pytest.fixture(scope="session", params=[2, 3])
def nominal(request: pytest.FixtureRequest, made: Callable[[Arm, int], Path]) -> Fmu:
    """The two-link nominal arm in both versions of the standard."""
    return Fmu(made(two_links(), request.param))


@pytest.fixture(scope="session")
def nominal3(made: Callable[[Arm, int], Path]) -> Fmu:
    return Fmu(made(two_links(), 3))
