"""Find and run phonanim: by the add-on's preferences, on PATH, or in Blender's own Python."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

from .takes import TakeError

MISSING = "phonanim is not found; pip install phonanim, and name the program in the add-on's preferences"


def find_phonanim(given: str = "") -> list[str]:
    """The command that runs phonanim. Raises TakeError without one."""
    program = given or shutil.which("phonanim") or ""
    if program:
        if not Path(program).is_file():
            raise TakeError(f"{program}: is not there; name another program in the add-on's preferences")
        return [program]
    if importlib.util.find_spec("phonanim"):
        return [sys.executable, "-m", "phonanim"]
    raise TakeError(MISSING)


def run_phonanim(given: str, *arguments: str) -> None:
    """Run a command of phonanim. Raises TakeError with the line that it ends with."""
    command = [*find_phonanim(given), *arguments]
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONHOME"}  # of Blender's Python
    done = subprocess.run(command, capture_output=True, text=True, env=clean, check=False)
    if done.returncode:
        told = [line for line in done.stderr.splitlines() if line.strip()] or [
            f"it ended with {done.returncode}"
        ]
        raise TakeError(f"phonanim: {told[-1]}")
