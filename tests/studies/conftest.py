from pathlib import Path

import pytest

STUDIES = Path(__file__).parents[2] / "studies"


@pytest.fixture(autouse=True)
def _beside_the_studies(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Let studies find their helpers as when they are run, and write elsewhere."""
    monkeypatch.syspath_prepend(str(STUDIES))
    import _output

    monkeypatch.setattr(_output, "OUT", tmp_path / "out")
