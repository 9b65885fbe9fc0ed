"""The number of threads of NumPy's linear algebra."""

from __future__ import annotations

import os

VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


def use_one_thread() -> None:
    """Make NumPy use one thread in this process and its child processes. Call it before NumPy is imported.

    Several threads divide the rows of a product in different ways, so the rounding differs. With one
    thread, the same input gives the same bytes on any number of cores. One thread also starts faster, and
    the matrices of a line are small: it is better to animate many lines in parallel.
    """
    os.environ.update(dict.fromkeys(VARIABLES, "1"))


def count_cores() -> int:
    """Number of processes that this machine runs at once."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
