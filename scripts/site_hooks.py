"""What `mkdocs build` makes besides the pages: takes for docs/gallery.md, and the site as a zip.

phonanim makes the takes from examples/line.TextGrid, so a site shows the motion of its own version.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
LINE, SOUND = ROOT / "examples" / "line.TextGrid", ROOT / "examples" / "line.wav"


def on_post_build(config: Any, **_: Any) -> None:
    """Write takes/ into the site, and the site's zip beside it."""
    site = Path(config["site_dir"])
    takes = site / "takes"
    takes.mkdir(parents=True, exist_ok=True)
    run("animate", LINE, "-o", takes / "line.html")
    run("animate", LINE, "--emotion", "joy=0.6", "-o", takes / "joy.html")
    for style in ("mumbled", "shouted"):
        run("animate", LINE, "--style", style, "-o", takes / f"{style}.npz")
    run(
        "convert", takes / "mumbled.npz", "-o", takes / "styles.html",
        "--compare-with", takes / "shouted.npz", "--audio", SOUND,
    )  # fmt: skip
    for path in takes.glob("*.npz"):
        path.unlink()
    shutil.make_archive(str(site), "zip", site.parent, site.name)


def run(*arguments: str | Path) -> None:
    """Run phonanim; a command that fails ends the build."""
    subprocess.run([sys.executable, "-m", "phonanim", *map(str, arguments), "--quiet"], check=True)
