"""How many threads NumPy's linear algebra takes."""

from __future__ import annotations

import os

VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


def one_thread() -> None:
    """Ask for one thread, unless the environment says otherwise; call it before NumPy is imported.

    Sums over several threads round otherwise than over one, so this is what makes the same input give the
    same bytes on every machine; it also starts faster, and many lines are better made side by side.
    """
    for name in VARIABLES:
        os.environ.setdefault(name, "1")
