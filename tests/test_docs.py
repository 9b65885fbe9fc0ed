"""The pages of the documentation: each is in the navigation, and shows the code of the example's files."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest

from phonanim.core.plugins import Registry

REGISTRIES = (
    "phonanim.readers.READERS",
    "phonanim.exporters.EXPORTERS",
    "phonanim.regressors.REGRESSORS",
    "phonanim.encoders.ENCODERS",
    "phonanim.datasets.DATASETS",
    "phonanim.stream.sinks.SINKS",
)


def test_every_page_is_in_the_navigation(root: Path) -> None:
    named = re.findall(r": (\S+\.md)$", (root / "mkdocs.yml").read_text("utf-8"), re.MULTILINE)
    pages = {path.relative_to(root / "docs").as_posix() for path in (root / "docs").rglob("*.md")}
    assert sorted(named) == sorted(pages)


def test_the_code_shown_is_that_of_the_example(root: Path) -> None:
    page = (root / "docs/extending.md").read_text("utf-8")
    shown = dict(re.findall(r'```\w+ title="([^"]+)"\n(.*?)```', page, re.DOTALL))
    for name, code in shown.items():
        assert code == (root / name).read_text("utf-8"), f"{name} has changed: copy it to docs/extending.md"
    files = (path for path in (root / "examples/plugin").rglob("*") if path.suffix in (".py", ".toml"))
    names = {path.relative_to(root).as_posix() for path in files if path.name != "__init__.py"}
    assert names == set(shown)


@pytest.mark.parametrize("name", REGISTRIES)
def test_every_group_is_described(root: Path, name: str) -> None:
    module, _, attribute = name.rpartition(".")
    registry: Registry = getattr(import_module(module), attribute)
    group = registry.group or registry.package
    row = re.search(rf"^\| `{group}` \|.*$", (root / "docs/extending.md").read_text("utf-8"), re.MULTILINE)
    assert row, group


def test_every_built_in_part_has_what_its_group_needs() -> None:
    checked = 0
    for name in REGISTRIES:
        module, _, attribute = name.rpartition(".")
        registry: Registry = getattr(import_module(module), attribute)
        for part in registry.built_in():
            found = registry.find(part)
            checked += 1
            assert [need for need in registry.needs if not hasattr(found, need)] == [], found
    assert checked > 50
