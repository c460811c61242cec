"""One thread a matrix product: on a busy machine threads that wait for each other take most of a fit's time."""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when numpy is first imported
