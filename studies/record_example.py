"""Question: which recording ships with the package? Records it again, byte for byte.

Method: an independent plant (`stribeck.withheld`) records six motions of a two-link arm with two hidden effects.
Expected: no change under ``src/stribeck/example``; what is hidden goes to the tests, away from the diagnoser.
"""

from pathlib import Path

from stribeck.withheld.example import write_example

ROOT = Path(__file__).parent.parent

if __name__ == "__main__":
    write_example(ROOT / "src/stribeck/example", ROOT / "tests/withheld/example_truth.json")
