"""Build the Blender extension from examples/blender: python scripts/build_blender_addon.py [-o FOLDER].

The same files give the same bytes.
"""

from __future__ import annotations

import argparse
import re
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "examples" / "blender"
NAMES = sorted((ROOT / "lexicon" / "rigs" / "names").glob("*.csv"))
EPOCH = (1980, 1, 1, 0, 0, 0)


def build(folder: Path) -> Path:
    """Write `phonanim-VERSION.zip` into a folder, and return its path."""
    manifest = (SOURCE / "blender_manifest.toml").read_text("utf-8")
    name, version = (re.search(rf'^{key} = "(.+)"$', manifest, re.MULTILINE) for key in ("id", "version"))
    if not name or not version:
        raise ValueError("blender_manifest.toml has no id or no version")
    files = [*sorted(SOURCE.glob("*.py")), SOURCE / "blender_manifest.toml", ROOT / "LICENSE"]
    entries = {path.name: path for path in files} | {f"names/{path.name}": path for path in NAMES}
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / f"{name[1]}-{version[1]}.zip"
    with zipfile.ZipFile(target, "w") as archive:
        for inside, path in entries.items():
            entry = zipfile.ZipInfo(inside, EPOCH)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, path.read_bytes())
    return target


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "dist")
    print(build(parser.parse_args().output))
