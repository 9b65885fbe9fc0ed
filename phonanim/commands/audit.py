"""`phonanim audit`: check a delivery before you send it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from phonanim.commands import Console, console_options
from phonanim.commands._renamed import renamed_option
from phonanim.core.catalog import DEFAULT_MODEL

if TYPE_CHECKING:
    from phonanim.dubbing.audit import Finding

FOUND = 1


@click.command()
@click.argument("source")
@renamed_option(
    "--outputs", "--delivered", required=True, help="The folder with the outputs, by path or URL."
)
@click.option(
    "--styles",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="TOML with the styles that a table names; phonanim's own by default.",
)
@click.option(
    "--characters",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="TOML or CSV with the characters that a table names, as for phonanim batch.",
)
@click.option(
    "--model",
    default=DEFAULT_MODEL,
    metavar="MODEL",
    help="The --model of the run, for cells with a style that it has learned.",
)
@click.option("--workers", type=click.IntRange(1, 512), help="Number of processes; one per core by default.")
@click.option("--verify", is_flag=True, help="Read every file again, also those of the same size and time.")
@console_options
def command(
    source: str,
    delivered: str,
    styles: Path | None,
    characters: Path | None,
    model: str,
    workers: int | None,
    verify: bool,
    console: Console,
) -> int:
    """Compare lines (a table, a folder, or a pattern) with the outputs made for them.

    Finds outputs that are missing, unreadable, stale (made from older inputs), still (nothing moves during
    speech) or mistimed, and orphans (files that belong to no line). The exit code is 1 when anything is
    found.

    \b
    Examples:
      phonanim audit script.csv --outputs out/
      phonanim audit lines/ --outputs curves/ --json
    """
    from phonanim.articulation.styles import read_styles
    from phonanim.core.threads import count_cores
    from phonanim.dubbing.audit import audit, count_problems
    from phonanim.dubbing.characters import read_characters
    from phonanim.dubbing.lines import read_lines
    from phonanim.dubbing.row import Common
    from phonanim.dubbing.storage import parse_place
    from phonanim.options import Options

    folder = parse_place(delivered)
    common = Common(
        Options(model=model),
        read_styles(styles),
        characters=read_characters(characters),
        corrections=folder,
    )
    lines = read_lines(source, common)
    findings = audit(lines, folder, workers or count_cores(), verify)
    totals = count_problems(findings)
    console.print_result(
        {"lines": len(lines.lines), "counts": totals, "findings": [asdict(finding) for finding in findings]},
        "\n".join(map(format_finding, findings)),
    )
    console.print(f"{len(lines.lines)} lines, {len(findings)} findings")
    for language, problems in totals.items():
        listed = ", ".join(f"{count} {problem}" for problem, count in problems.items())
        console.print(f"{language or 'no language'}: {listed}")
    return FOUND if findings else 0


def format_finding(finding: Finding) -> str:
    """One finding as text."""
    return f"{finding.problem:<10} {finding.id}: {finding.text}"
