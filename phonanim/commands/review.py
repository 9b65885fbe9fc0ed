"""`phonanim review`: look through the lines of a run in the browser, correct them, and decide."""

from __future__ import annotations

import secrets
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

import click

from phonanim.commands import Console, console_options

if TYPE_CHECKING:
    from phonanim.dubbing.lines import Lines
    from phonanim.dubbing.review import Review


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "--source", help="The table or folder of the run; by default the one that the run was made from."
)
@click.option(
    "--characters",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="TOML or CSV with the characters that the table of --source names, as for phonanim batch.",
)
@click.option("--who", help="Your name beside what you do; by default that of your account.")
@click.option(
    "--csv", "table", type=click.Path(dir_okay=False, path_type=Path), help="Write the list, and end."
)
@click.option(
    "--export",
    "export",
    type=click.Path(file_okay=False, path_type=Path),
    help="Write the review to a folder of pages that need no server, to be sent, and end.",
)
@click.option(
    "--only",
    multiple=True,
    type=click.Choice(["failed", "flagged", "good", "approved", "rejected", "undecided", "commented"]),
    help="Export such lines alone. Repeatable.",
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port; 0 takes a free one.")
@click.option("--no-browser", is_flag=True, help="Print the address, and open nothing.")
@console_options
def command(
    folder: Path,
    source: str | None,
    characters: Path | None,
    who: str | None,
    table: Path | None,
    export: Path | None,
    only: tuple[str, ...],
    port: int,
    no_browser: bool,
    console: Console,
) -> None:
    """List the lines of a finished run, the worst first, play, correct, approve and reject them.

    The page is served on this machine alone, at an address with a token, until Ctrl-C. What is corrected is
    kept beside the outputs, and the next `phonanim batch` has it; decisions and comments are kept in
    review.sqlite there.

    \b
    Examples:
      phonanim review out/
      phonanim review out/ --who Ann
      phonanim review out/ --csv decisions.csv
      phonanim review out/ --export to_send/ --only rejected --only commented
    """
    review = find_review(folder, source, characters)
    if table is not None:
        write_table(review, table)
        console.print_result({"lines": len(review.outcomes), "output": str(table)}, str(table))
        return
    if export is not None:
        count = export_pages(review, export, only, console)
        console.print_result({"lines": count, "output": str(export)}, str(export / "index.html"))
        return
    serve(review, port, who or account_name(), no_browser, console)


def find_review(folder: Path, source: str | None, characters: Path | None) -> Review:
    """The review of a folder, with the lines of the run where they are known."""
    from phonanim.dubbing.characters import read_characters
    from phonanim.dubbing.lines import read_lines
    from phonanim.dubbing.review import open_review
    from phonanim.dubbing.row import Common

    folder = folder.absolute()
    lines: Lines | None
    if source:
        lines = read_lines(source, Common(characters=read_characters(characters), corrections=folder))
    else:
        lines = lines_of_run(folder)
    return open_review(folder, lines)


def lines_of_run(folder: Path) -> Lines | None:
    """The lines of the run in a folder, with its options; None where they are not known."""
    from phonanim.commands._export import export_options
    from phonanim.commands._options import animation_options
    from phonanim.commands._run_file import call_as_kept
    from phonanim.commands.batch import command, plan_lines

    planned = call_as_kept(folder, command, animation_options(export_options(console_options(plan_lines))))
    return None if planned is None else planned[0]


def account_name() -> str:
    """The name of the account that runs this."""
    import getpass

    try:
        return getpass.getuser()
    except (KeyError, OSError, ImportError):
        return ""


def write_table(review: Review, path: Path) -> None:
    """Write the list with decisions and comments."""
    from phonanim.core.files import write_text
    from phonanim.dubbing.review_line import Desk
    from phonanim.dubbing.review_table import review_csv

    write_text(path, review_csv(Desk(review, review.decisions())))


def export_pages(review: Review, folder: Path, only: tuple[str, ...], console: Console) -> int:
    """Write the review to a folder; returns the number of lines."""
    from phonanim.dubbing.review_export import export_review
    from phonanim.dubbing.review_line import Desk
    from phonanim.errors import OptionError

    if folder.resolve().is_relative_to(review.folder.resolve()):
        raise OptionError(f"{folder}: is inside the run; name another folder")
    with console.progress(str(folder)) as progress:
        return export_review(Desk(review, review.decisions()), folder, only, progress)


def serve(review: Review, port: int, who: str, no_browser: bool, console: Console) -> None:
    """Serve the pages until Ctrl-C."""
    from phonanim.dubbing.review_server import ReviewServer
    from phonanim.errors import OutputError

    try:
        server = ReviewServer(review, secrets.token_urlsafe(24), port, who)
    except OSError as error:
        raise OutputError(
            f"port {port}: cannot be opened: {error.strerror}; choose another --port"
        ) from error
    with server:
        console.print_result({"address": server.address, "lines": len(review.outcomes)}, server.address)
        if not no_browser:
            webbrowser.open(server.address)
        if not review.lines:
            console.print("how the run was made is not known, so lines cannot be corrected; give --source")
        console.print(f"{len(review.outcomes)} lines; Ctrl-C ends the review")
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            console.print("ended")
