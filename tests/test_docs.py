"""The pages of the documentation: each is in the navigation, and shows the code of the example's files."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest

from phonanim.core.plugins import Registry

LONGEST = 1500  # words of a page that is read from start to end
REFERENCES = {  # pages in which one looks something up: tables of formats, measures, settings, figures
    *("alignment_formats.md", "audio_measured.md", "datasets.md", "facediffuser_measured.md"),
    *("language_tables.md", "measures.md", "taylor2017.md"),
}
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
    found = (path.relative_to(root) for path in (root / "examples/plugin").rglob("*.*"))
    files = (path for path in found if path.suffix in (".py", ".toml") and path.name != "__init__.py")
    names = {path.as_posix() for path in files if "build" not in path.parts}  # which pip leaves
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


def pages(root: Path) -> list[Path]:
    """Every page a reader may open first."""
    return [root / "README.md", root / "CONTRIBUTING.md", *sorted((root / "docs").rglob("*.md"))]


def test_a_page_is_short_or_a_reference(root: Path) -> None:
    long = [
        path.relative_to(root / "docs").as_posix()
        for path in (root / "docs").rglob("*.md")
        if len(path.read_text("utf-8").split()) > LONGEST
    ]
    assert sorted(name for name in long if name not in REFERENCES and not name.startswith("benchmark/")) == []


def test_every_picture_says_what_it_shows(root: Path) -> None:
    for path in pages(root):
        for text in re.findall(r"!\[([^\]]*)\]", path.read_text("utf-8")):
            assert len(text.split()) >= 4, f"{path.relative_to(root)}: the picture {text!r} needs a text"


def test_pages_that_the_program_names_exist(root: Path) -> None:
    folders = (root / "phonanim", root / "benchmarks", root / "scripts", root / "lexicon")
    files = [path for folder in folders for path in folder.rglob("*") if path.suffix in (".py", ".toml")]
    for path in (*files, *pages(root), root / "CHANGELOG.md"):
        for name in re.findall(r"\bdocs/[\w/]+\.md\b", path.read_text("utf-8")):
            assert (root / name).is_file(), f"{path.relative_to(root)} names {name}"


def test_no_page_names_a_folder_that_its_reader_lacks(root: Path) -> None:
    for path in pages(root):
        found = re.search(r"\.\./shared|/work/shared|/tmp/|/root/|/home/", path.read_text("utf-8"))
        assert not found, f"{path.relative_to(root)}: {found and found.group()}"


def test_measured_tables_say_how_many_seconds_they_rest_on(root: Path) -> None:
    """In the text of their section, or above the first heading of the page."""
    docs, silent = root / "docs", []
    named = [docs / f"{name}.md" for name in ("align_confidence", "articulation_accuracy", "ema_predicted")]
    benchmark = [*docs.glob("benchmark*.md"), *docs.glob("benchmark/*.md")]
    for page in [*benchmark, *docs.glob("*_measured.md"), *named]:
        lead, *sections = re.split(r"^##+ ", page.read_text("utf-8"), flags=re.MULTILINE)
        for section in sections or [""]:
            lines = (lead + section).splitlines()
            text = "\n".join(line for line in lines if not line.startswith("|"))
            if any(line.startswith("|") for line in lines) and not re.search(r"\d (s|minutes|hours)\b", text):
                silent.append(f"{page.name}: {section.partition(chr(10))[0]}")
    assert silent == []
