"""How much each extra of pyproject.toml brings; run it with all extras installed.

Prints for each extra the packages that it adds to the plain installation, and their installed size by the
records of the packages. An extra that is not installed completely names the packages that are missing.
"""

from __future__ import annotations

import re
from importlib.metadata import Distribution, PackageNotFoundError, distribution, requires
from pathlib import Path

from packaging.requirements import Requirement

from phonanim.core.decode import read_toml

PROJECT = Path(__file__).parent.parent / "pyproject.toml"
HIDDEN = ("test", "dev", "docs", "mutation")
NAME = re.compile(r"([A-Za-z0-9._-]+)(?:\[([\w,-]+)\])?")


def main() -> None:
    """Print the table."""
    project = read_toml(PROJECT)["project"]
    extras: dict[str, list[str]] = project["optional-dependencies"]
    plain, _ = closure(project["dependencies"], extras)
    print(f"{'(plain)':<12}{size(plain):8.1f} MB  {', '.join(sorted(plain))}")
    for name in (name for name in extras if name not in HIDDEN):
        found, missing = closure(extras[name], extras)
        more = f"  missing: {', '.join(sorted(missing))}" if missing else ""
        own = set(found) - set(plain)
        print(f"{name:<12}{size(own):8.1f} MB  {', '.join(sorted(own))}{more}")


def closure(texts: list[str], extras: dict[str, list[str]]) -> tuple[set[str], set[str]]:
    """The packages that requirements bring, and those of them that are not installed."""
    waiting, found, missing = list(texts), set[str](), set[str]()
    while waiting:
        text = waiting.pop()
        if "extra ==" in text or not applies(text):
            continue
        match = NAME.match(text)
        if match is None:
            continue
        name, parts = match[1].lower().replace("_", "-"), match[2]
        if name == "phonanim":
            waiting += [one for part in (parts or "").split(",") for one in extras.get(part, [])]
        elif name not in found | missing:
            try:
                waiting += requires(name) or []
                found.add(name)
            except PackageNotFoundError:
                missing.add(name)
    return found, missing


def applies(text: str) -> bool:
    """Whether a requirement is for this machine."""
    marker = Requirement(text).marker
    return marker is None or marker.evaluate({"extra": ""})


def size(names: set[str]) -> float:
    """Installed megabytes."""
    return sum(bytes_of(distribution(name)) for name in names) / 1e6


def bytes_of(package: Distribution) -> int:
    """The bytes of the files of a package."""
    paths = (Path(str(file.locate())) for file in package.files or ())
    return sum(path.stat().st_size for path in paths if path.is_file())


if __name__ == "__main__":
    main()
