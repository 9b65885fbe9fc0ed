"""Check that a tag, the package and the changelog name one version, before it is published.

python scripts/check_release.py v0.1.0
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VERSIONS = {
    "phonanim/core/version.py": r'__version__ = "([^"]+)"',
    "CHANGELOG.md": r"^## (\S+)$",
    "CITATION.cff": r"^version: (\S+)$",
    "examples/web/package.json": r'"version": "([^"]+)"',
    "examples/blender/blender_manifest.toml": r'^version = "([^"]+)"',
}


def find_versions() -> dict[str, str]:
    """The version that each file names first; "none" where it names none."""
    found = {}
    for name, pattern in VERSIONS.items():
        match = re.search(pattern, (ROOT / name).read_text("utf-8"), re.MULTILINE)
        found[name] = match[1] if match else "none"
    return found


def main() -> None:
    """Exit with 1 and name the files that differ from the tag."""
    tag = sys.argv[1].removeprefix("v")
    wrong = [f"{name} has {version}" for name, version in find_versions().items() if version != tag]
    if wrong:
        sys.exit(f"the tag is {sys.argv[1]}, but {', '.join(wrong)}")
    print(f"version {tag} in {len(VERSIONS)} files")


if __name__ == "__main__":
    main()
