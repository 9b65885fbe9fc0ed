"""`phonanim review`: look through the lines of a run in the browser."""

from __future__ import annotations

import secrets
import webbrowser
from pathlib import Path

import click

from phonanim.commands import Console, console_options


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "--source", help="The table or folder of the run, for the recordings, and phones of curves alone."
)
@click.option(
    "--characters",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="TOML or CSV with the characters that the table names, as for phonanim batch.",
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port; 0 takes a free one.")
@click.option("--no-browser", is_flag=True, help="Print the address, and open nothing.")
@console_options
def command(
    folder: Path, source: str | None, characters: Path | None, port: int, no_browser: bool, console: Console
) -> None:
    """List the lines of a finished run, the worst first, and play each on the shipped head.

    The page is served on this machine alone, at an address with a token, until Ctrl-C. It searches, and
    filters by status, flag, language and rig. Lines are played from an output that can be read back.

    \b
    Examples:
      phonanim review out/
      phonanim review out/ --source script.csv
    """
    from phonanim.dubbing.characters import read_characters
    from phonanim.dubbing.lines import read_lines
    from phonanim.dubbing.review import open_review
    from phonanim.dubbing.review_server import ReviewServer
    from phonanim.dubbing.row import Common
    from phonanim.errors import OutputError

    lines = read_lines(source, Common(characters=read_characters(characters))) if source else None
    review = open_review(folder, lines)
    try:
        server = ReviewServer(review, secrets.token_urlsafe(24), port)
    except OSError as error:
        raise OutputError(
            f"port {port}: cannot be opened: {error.strerror}; choose another --port"
        ) from error
    with server:
        console.print_result({"address": server.address, "lines": len(review.outcomes)}, server.address)
        if not no_browser:
            webbrowser.open(server.address)
        console.print(f"{len(review.outcomes)} lines; Ctrl-C ends the review")
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            console.print("ended")
