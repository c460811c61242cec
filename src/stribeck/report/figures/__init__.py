"""One file per figure: each takes a result and returns a ``Figure``, or None where there is nothing to draw."""
