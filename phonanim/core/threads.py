"""How many threads NumPy's linear algebra takes."""

from __future__ import annotations

import os

VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


def use_one_thread() -> None:
    """Make NumPy use one thread in this process and those it starts; call it before NumPy is imported.

    Several threads share the rows of a product differently and so round differently: with one, the same
    input gives the same bytes on any number of cores. It also starts faster, and the matrices of a line
    are small: many lines are better made side by side.
    """
    os.environ.update(dict.fromkeys(VARIABLES, "1"))
