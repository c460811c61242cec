"""What holds for all tests, on a busy machine too.

One thread a matrix product: threads that wait for each other take most of a fit's time. No deadline for an example of
a property: the first may wait for an import, or for whoever else is using the machine. And one cache of compiled code.
"""

import gc
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when numpy is first imported

from collections.abc import Iterator

import pytest
from hypothesis import settings

settings.register_profile("patient", deadline=None)
settings.load_profile("patient")


def pytest_collection_finish() -> None:
    """Spare the collector what is imported by now and stays: it would go through all of it again and again."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def _own_cache(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Leave the user's cache alone; what is compiled once stays in .pytest_cache for the next session."""
    if "STRIBECK_CACHE" in os.environ:
        yield
        return
    kept = getattr(request.config, "cache", None)  # none with -p no:cacheprovider
    folder = kept.mkdir("compiled") if kept else tmp_path_factory.mktemp("compiled")
    folder.chmod(0o700)  # as the compiler's cache demands
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STRIBECK_CACHE", str(folder))
        yield
