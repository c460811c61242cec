"""What a claim of the paper comes to: its words (``claims.toml``), and how a verdict follows from what was measured."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HOLDS, HOLDS_IF, FAILS = "holds", "holds if", "does not hold"


@dataclass(frozen=True)
class Claim:
    """One claim: its key in ``claims.toml``, the verdict, what was measured, and the figure that shows it."""

    key: str
    verdict: str
    measured: Mapping[str, Any]
    figure: str

    @property
    def words(self) -> dict[str, str]:
        """Claim, section of the paper, and condition or reason."""
        texts = tomllib.loads(Path(__file__).with_name("claims.toml").read_text(encoding="utf-8"))
        return dict(texts[self.key])

    def row(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {**self.words, "verdict": self.verdict, "figure": f"{self.figure}.png", "measured": self.measured}


def judged(always: bool, sometimes: bool = False) -> str:
    """Return the verdict: what is always so holds, what is so under a condition holds if, the rest does not."""
    return HOLDS if always else HOLDS_IF if sometimes else FAILS


def close(value: float, expected: float, relative: float) -> bool:
    """Return whether a value is within a relative distance of what is expected."""
    return abs(value - expected) <= relative * abs(expected)


def as_markdown(claims: list[Claim]) -> str:
    """Return the table."""
    lines = ["| claim | section | verdict | why, or when | figure |", "|---|---|---|---|---|"]
    for one in claims:
        words = {name: text.replace("|", "\\|") for name, text in one.words.items()}
        cells = (words["claim"], words["where"], one.verdict, words["why"], f"{one.figure}.png")
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"
