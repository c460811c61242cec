"""What is being done is shown while it is done; what is a warning stays on the screen."""

import io

import pytest
from rich.console import Console

from stribeck.cli import shared
from stribeck.errors import WARNING


@pytest.mark.parametrize(
    ("terminal", "shown"),
    [(False, ["diagnosing: re-tuning", "diagnosing: warning: turned", "diagnosing: screening"]), (True, None)],
)
def test_a_warning_stays(
    terminal: bool, shown: list[str] | None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    screen = io.StringIO()
    monkeypatch.setattr(shared, "Console", lambda **_: Console(file=screen, force_terminal=terminal, width=80))
    with shared.progress("diagnosing") as told:
        for text in ("re-tuning", f"{WARNING}turned", "screening"):
            told(text)
    if shown is None:
        lines = screen.getvalue().split("\n")
        assert any(line.rstrip("\r").endswith("warning: turned") for line in lines)
    else:
        assert capsys.readouterr().err.splitlines() == shown
