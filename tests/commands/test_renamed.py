"""Former spellings of options: they work as the new ones do, and only the new ones are shown."""

from __future__ import annotations

from pathlib import Path

import click
import pytest

from phonanim.__main__ import commands, run

ANIMATE = {
    "--on-unknown-label": ("--unknown", "nearest"),
    "--fallback-language": ("--fallback", "ipa"),
    "--key-tolerance": ("--keys", "0.01"),
    "--contact-sheet": ("--sheet", "a.png"),
}
RENAMED = [
    *(("animate", new, old, value) for new, (old, value) in ANIMATE.items()),
    ("batch", "--on-unknown-label", "--unknown", "nearest"),
    ("batch", "--key-tolerance", "--keys", "0.01"),
    ("convert", "--compare-with", "--beside", "b.npz"),
    ("convert", "--contact-sheet", "--sheet", "a.png"),
    ("rig check", "--contact-sheet", "--sheet", "a.png"),
    ("rig fit", "--contact-sheet", "--sheet", "a.png"),
    ("ema report", "--bite-plate", "--bite", "b.pos"),
    ("ema report", "--min-examples", "--least", "3"),
    ("study analyse", "--max-failed-controls", "--allow", "2"),
    ("audit", "--outputs", "--delivered", "out"),
]


def find_command(name: str) -> tuple[click.Command, click.Context]:
    command: click.Command = commands
    context = click.Context(command, info_name="phonanim")
    for part in name.split():
        assert isinstance(command, click.Group)
        found = command.get_command(context, part)
        assert found is not None
        command, context = found, click.Context(found, info_name=part, parent=context)
    return command, context


@pytest.mark.parametrize(("name", "new", "old", "value"), RENAMED)
def test_both_spellings_are_one_option_and_help_shows_the_new(
    name: str, new: str, old: str, value: str
) -> None:
    command, context = find_command(name)
    given = [command.make_parser(context).parse_args([word, value])[0] for word in (new, old)]
    assert given[0] == given[1]
    assert value in given[0].values()
    words = command.get_help(context).split()
    assert new in words
    assert old not in words


def test_former_spellings_write_the_same_bytes(root: Path, tmp_path: Path) -> None:
    line = str(root / "examples" / "line.TextGrid")
    for number in (0, 1):
        words = [
            word
            for new, (old, value) in ANIMATE.items()
            for word in ((new, old)[number], value.replace("a.png", str(tmp_path / f"{number}.png")))
        ]
        output = str(tmp_path / f"{number}.anim")
        assert run(["animate", line, "-o", output, "-q", *words]) == 0
    for suffix in ("anim", "png"):
        assert (tmp_path / f"0.{suffix}").read_bytes() == (tmp_path / f"1.{suffix}").read_bytes()


def test_errors_show_the_new_spelling(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["animate", "a.TextGrid", "--unknown", "perhaps"]) == 2
    message = capsys.readouterr().err
    assert "--on-unknown-label" in message
    assert "--unknown'" not in message
