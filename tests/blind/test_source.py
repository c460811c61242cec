"""What an answer depends on is in its digest."""

from pathlib import Path

import grimp

import stribeck
from stribeck.blind.source import PARTS, SUFFIXES


def test_the_digest_covers_all_that_a_diagnosis_imports() -> None:
    """Else answers of two methods pass for those of one."""
    graph = grimp.build_graph("stribeck")
    upstream = {m for end in ("diagnose", "answer.files") for m in graph.find_upstream_modules(f"stribeck.gap.{end}")}
    assert {module.split(".")[1] for module in upstream if "." in module} | {"gap"} == set(PARTS)


def test_and_what_is_compiled() -> None:
    """What lies in those folders is told apart by its suffix: no kind of source is left out."""
    root = Path(stribeck.__file__).parent
    kinds = {path.suffix for part in PARTS for path in (root / part).rglob("*") if path.is_file()}
    assert kinds - {".md", ".png", ".pyc"} <= set(SUFFIXES)
