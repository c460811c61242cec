"""What is compiled goes into a folder of the test session."""

from collections.abc import Iterator

import pytest


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STRIBECK_CACHE", str(tmp_path_factory.mktemp("compiled")))
        yield
