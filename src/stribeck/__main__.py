"""The program from its first moment: a stop is answered in one line while most of it is still being imported, too."""

import signal
import sys

from stribeck.stopping import stop_if_asked, stoppable


def main() -> int:
    """Import the program and run it; return its exit status (see `stribeck.cli.main`)."""
    try:
        with stoppable():
            try:
                from stribeck.cli import main as program
            finally:
                stop_if_asked()  # a package may have made an error of its own of it
            return program()
    except KeyboardInterrupt:
        print("stribeck: interrupted", file=sys.stderr)
        return 128 + signal.SIGINT


if __name__ == "__main__":
    sys.exit(main())
