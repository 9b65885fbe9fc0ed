"""Open a page in the browser."""

from __future__ import annotations

import webbrowser
from pathlib import Path

from phonanim.commands import Console


def open_page(path: Path, console: Console) -> None:
    """Open an HTML file in the browser, or say how where there is none."""
    if webbrowser.open(path.resolve().as_uri()):
        console.print(f"opened {path} in the browser")
    else:
        console.print(f"no browser was found: open {path} in one")
