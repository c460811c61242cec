"""``python -m stribeck``: the program, where its script is not on the path."""

import sys

from stribeck.cli import main

if __name__ == "__main__":
    sys.exit(main())
