"""Print the lowest version of each dependency that pyproject.toml declares, as constraints for pip.

python scripts/lowest_versions.py > lowest.txt
pip install -c lowest.txt .
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PROJECT = Path(__file__).parent.parent / "pyproject.toml"


def lowest_versions(requirements: Iterable[str]) -> list[str]:
    """Turn `name>=version` into `name==version` and keep the marker. Raises ValueError where none is."""
    pinned = []
    for requirement in requirements:
        found = re.fullmatch(r"([\w-]+)>=([\w.]+)(\s*;.*)?", requirement)
        if found is None:
            raise ValueError(f"{PROJECT}: {requirement!r} has no lowest version; write name>=version")
        pinned.append(f"{found[1]}=={found[2]}{found[3] or ''}")
    return pinned


if __name__ == "__main__":
    declared = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]["dependencies"]
    print("\n".join(lowest_versions(declared)))
