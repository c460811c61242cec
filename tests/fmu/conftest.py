"""The FMUs of the folders in ``fmu/``, for this platform, and of the loop's controllers."""

from pathlib import Path

import fmpy
import pytest

from stribeck.arm import Arm, load_arm
from stribeck.export import export_fmu
from stribeck.export.controller import export_controller
from stribeck.simulate import Loop, load_loop

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "fmu"
HERE = [fmpy.platform_tuple]


@pytest.fixture(scope="session")
def arm() -> Arm:
    return load_arm(MODELS / "two_link_nominal" / "arm.toml")


@pytest.fixture(scope="session")
def loop(arm: Arm) -> Loop:
    return load_loop(MODELS / "two_link_nominal" / "loop.toml", arm)


@pytest.fixture(scope="session", params=[2, 3])
def fmi(request: pytest.FixtureRequest) -> int:
    version: int = request.param
    return version


@pytest.fixture(scope="session")
def arm_fmu(arm: Arm, fmi: int, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fmu") / f"arm{fmi}.fmu"
    export_fmu(arm, path, fmi=fmi, platforms=HERE)
    return path


@pytest.fixture(scope="session")
def controller_fmu(arm: Arm, loop: Loop, fmi: int, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fmu") / f"controller{fmi}.fmu"
    export_controller(arm, loop, path, fmi=fmi, platforms=HERE)
    return path
