"""Where studies write: ``studies/out/<name>/``, which git ignores."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from stribeck.report.style import png

OUT = Path(__file__).with_name("out")


def write(name: str, result: dict[str, Any], **figures: Figure | None) -> Path:
    """Write ``result.json`` and each figure there is as a PNG of its name; return the folder."""
    folder = OUT / name
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(_plain(result), indent=2, allow_nan=False)
    (folder / "result.json").write_text(text + "\n", encoding="utf-8")
    for key, figure in figures.items():
        if figure is not None:
            (folder / f"{key}.png").write_bytes(png(figure))
    return folder


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value
