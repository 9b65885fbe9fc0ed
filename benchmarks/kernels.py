"""Animate a line by the code for several processor types, and measure how far the values differ.

    python benchmarks/kernels.py examples/line.TextGrid
    python benchmarks/kernels.py examples/line.TextGrid --python other/bin/python

With `--python`, each type is also tried with the NumPy of another environment.

OpenBLAS, which multiplies matrices for NumPy, chooses its kernel by OPENBLAS_CORETYPE. A type that this
processor cannot run ends in an illegal instruction, and is left out. The last two types run NumPy's own loops
without the instructions of newer processors, and without AVX2.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path

import numpy as np

NO_AVX512 = "X86_V4 AVX512_ICL AVX512_SPR AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL"
TYPES = {
    **{
        kind: {"OPENBLAS_CORETYPE": kind}
        for kind in ("Haswell", "Zen", "SkylakeX", "Sandybridge", "Nehalem", "Prescott")
    },
    "no AVX-512": {"NPY_DISABLE_CPU_FEATURES": NO_AVX512},
    "no AVX2": {"NPY_DISABLE_CPU_FEATURES": f"{NO_AVX512} X86_V3 AVX2 FMA3"},
}


def main() -> None:
    """Print, for each type, the largest difference to the first one and the share of frames that differ."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("alignment", type=Path)
    parser.add_argument("--rig", default="arkit")
    parser.add_argument("--python", action="append", default=[], help="of an environment with another NumPy")
    options = parser.parse_args()
    first = None
    print(f"{'NumPy':<8}{'type':<12}{'largest':>12}{'frames':>10}")
    for python, kind in product([sys.executable, *options.python], TYPES):
        values = animate_by(TYPES[kind], options.alignment, options.rig, python)
        version = numpy_of(python)
        if values is None:
            print(f"{version:<8}{kind:<12}{'cannot run here':>22}")
            continue
        first = values if first is None else first
        differs = (values != first).any(axis=1).mean()
        print(f"{version:<8}{kind:<12}{np.abs(values - first).max():>12.1e}{differs:>10.0%}")


def numpy_of(python: str) -> str:
    """The version of NumPy of an environment."""
    code = "import numpy; print(numpy.__version__)"
    return subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def animate_by(kind: dict[str, str], alignment: Path, rig: str, python: str) -> np.ndarray | None:
    """The curves by the code for a processor type, (frames, channels); None where it cannot run."""
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "a.npz"
        command = [
            python,
            "-m",
            "phonanim",
            "animate",
            str(alignment),
            "-o",
            str(output),
            "--rig",
            rig,
        ]
        done = subprocess.run([*command, "-q"], env={**os.environ, **kind}, check=False)
        if done.returncode:
            return None
        with np.load(output) as archive:
            return np.asarray(archive["values"])


if __name__ == "__main__":
    main()
