"""What the README and the pages under docs say can be done."""

import re
import shlex
import shutil

import click
import pytest

from phonanim.__main__ import commands
from phonanim.readers import reader_names


@pytest.fixture
def readme(root):
    return (root / "README.md").read_text("utf-8")


def test_the_python_example_runs(readme, root, tmp_path, monkeypatch):
    (code,) = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    shutil.copy(root / "examples/line.TextGrid", tmp_path)
    monkeypatch.chdir(tmp_path)
    scope = {}
    exec(code, scope)
    assert (tmp_path / "line.csv").is_file()
    assert scope["jaw"].max() > 0.05


def test_the_number_of_formats_is_that_of_the_readers(readme):
    assert f"a TextGrid, or one of {len(reader_names()) - 1} other formats" in readme


def test_links_and_pictures_exist(root):
    for page in (root / "README.md", root / "CONTRIBUTING.md", *(root / "docs").rglob("*.md")):
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text("utf-8")):
            assert (page.parent / target).exists(), f"{page.relative_to(root)}: {target}"


def shown_commands(root):
    """Every command line in a code block of the README or a page, without what follows two blanks."""
    for page in (root / "README.md", *(root / "docs").rglob("*.md")):
        blocks = re.findall(r"^```(\w*)[^\n]*\n(.*?)^```$", page.read_text("utf-8"), re.DOTALL | re.MULTILINE)
        for block in (text for kind, text in blocks if kind in ("", "sh")):
            whole = re.sub(r" *\\\n\s*", " ", block)  # a line may go on after a backslash
            for line in re.findall(r"^phonanim .*$", whole, re.MULTILINE):
                yield page.name, re.split(r"\s{2,}|\s#", line)[0]


def test_commands_shown_take_their_options(root):
    shown = list(shown_commands(root))
    assert len(shown) > 10
    for page, line in shown:
        words = shlex.split(line)[1:]
        command: click.Command = commands
        while isinstance(command, click.Group):
            name = words.pop(0)
            command = command.get_command(click.Context(command), name)
            assert command, f"{page}: {line}"
        known = {
            option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)
        }
        used = {word for word in words if re.match(r"--?[a-z]", word)}
        assert used <= known, f"{page}: {line}"
