"""Run the commands of pages of the documentation, and compare what they print with what the page shows.

    python scripts/run_pages.py docs/journeys/*.md            in this environment
    python scripts/run_pages.py --fresh docs/journeys/*.md    in a new environment each, with a table of times

All `sh` blocks of a page run in bash, in order and in one folder. A `text` block right after one is what it
prints, where `...` stands for anything. A block with `title="NAME"` is a file of that name. Blocks of other
kinds are for reading. The folder holds nothing else; beside it lies `phonanim`, the repository.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FENCE = re.compile(r"^```(\w+)(?: title=\"([^\"]+)\")?\n(.*?)^```$", re.DOTALL | re.MULTILINE)
INSTALLS = re.compile(r"^(?:python -m venv|pip install|npm install|\. env/)")


class PageError(Exception):
    """A command of a page failed, or printed something else than the page shows."""


@dataclass(frozen=True)
class Block:
    """A file (`name`), or commands and what they print; None where the page does not show it."""

    text: str
    name: str = ""
    printed: str | None = None

    @property
    def commands(self) -> list[str]:
        """The lines of commands, continued lines joined."""
        lines = re.sub(r"\\\n\s*", "", self.text).splitlines()
        return [] if self.name else [line for line in lines if line.strip() and not line.startswith("#")]


def read_blocks(page: str) -> Iterator[Block]:
    """The blocks of a page that are run or written, in their order."""
    found = list(FENCE.finditer(page))
    for fence, after in zip(found, [*found[1:], None], strict=True):
        kind, name, text = fence.groups()
        if name:
            yield Block(text, name)
        elif kind == "sh":
            follows = (
                after is not None and after[1] == "text" and not page[fence.end() : after.start()].strip()
            )
            yield Block(text, printed=after[3] if follows and after is not None else None)


def run_block(block: Block, folder: Path, installs: bool = True) -> None:
    """Write the file of a block, or run its commands in the folder. Raises PageError."""
    if block.name:
        path = folder / block.name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(block.text, "utf-8")
        return
    commands = [line for line in block.commands if installs or not INSTALLS.match(line)]
    if not commands:
        return
    activate = ". env/bin/activate\n" if (folder / "env").is_dir() else ""
    script = activate + "\n".join(commands)
    environment = {**os.environ, "PYTHONUNBUFFERED": "1", "COLUMNS": "200"}
    done = subprocess.run(
        ["bash", "-ec", script],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        stdin=subprocess.DEVNULL,
        text=True,
        check=False,
    )
    if done.returncode:
        raise PageError(f"exit code {done.returncode} of\n{script}\n{done.stdout}")
    if block.printed is not None and not prints(block.printed, done.stdout):
        raise PageError(f"{script}\nprints\n{done.stdout}\nand the page shows\n{block.printed}")


def prints(shown: str, printed: str) -> bool:
    """Whether what was printed is what the page shows; `...` stands for anything, and blanks do not count."""
    parts = (re.escape(" ".join(part.split())) for part in shown.split("..."))
    return bool(re.fullmatch(r"\s*.*\s*".join(parts), " ".join(printed.split()), re.DOTALL))


def run_page(page: str, folder: Path, installs: bool = True) -> int:
    """Run a page in a new folder `work` beside a link to the repository; the number of its commands."""
    (folder / "phonanim").symlink_to(ROOT, target_is_directory=True)
    work = folder / "work"
    work.mkdir()
    blocks = list(read_blocks(page))
    for block in blocks:
        run_block(block, work, installs)
    return sum(len(block.commands) for block in blocks)


def main() -> None:
    """Run pages, and print their commands and minutes."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("pages", nargs="+", type=Path)
    parser.add_argument("--fresh", action="store_true", help="also run the lines that install")
    arguments = parser.parse_args()
    failed = False
    print("| page | commands | minutes |\n|---|---:|---:|")
    for page in arguments.pages:
        begun = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            try:
                count = run_page(page.read_text("utf-8"), Path(folder), arguments.fresh)
            except PageError as error:
                failed = True
                print(f"{page}: {error}", file=sys.stderr)
                continue
        print(f"| {page.name} | {count} | {(time.monotonic() - begun) / 60:.1f} |", flush=True)
    sys.exit(failed)


if __name__ == "__main__":
    main()
