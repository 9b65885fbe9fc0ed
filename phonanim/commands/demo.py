"""`phonanim demo`: a speaking face in the browser, from a sentence of your own."""

from __future__ import annotations

import importlib.util
import shutil
import tempfile
from pathlib import Path

import click

from phonanim.commands import Console, console_options

PAGE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("text", required=False)
@click.option("--voice", default="en-us", help="Voice of eSpeak NG: a language code, such as de.")
@click.option("-o", "--output", type=PAGE, default=Path("demo.html"), help="The page to write.")
@click.option("--view/--no-view", default=True, help="Open the page in the browser.")
@console_options
def command(text: str | None, voice: str, output: Path, view: bool, console: Console) -> None:
    """Write a page on which the shipped head speaks TEXT, and open it.

    Without TEXT, the head speaks a sentence that comes with phonanim. TEXT is spoken by eSpeak NG
    (pip install 'phonanim[espeak]').

    \b
    Examples:
      phonanim demo
      phonanim demo "Hello, this is my own sentence."
      phonanim demo "Guten Morgen, Mama." --voice de -o morgen.html
    """
    from phonanim.commands._view import open_page
    from phonanim.errors import OptionError
    from phonanim.pipeline import animate

    if output.suffix.lower() not in (".html", ".htm"):
        raise OptionError(f"{output}: the demo is a page; name it .html, or use phonanim animate")
    if text is None and importlib.util.find_spec("espeakng_loader") is None:
        console.print("for a sentence of your own: pip install 'phonanim[espeak]', phonanim demo \"Hello.\"")
    with tempfile.TemporaryDirectory(prefix="phonanim-demo-") as folder:
        alignment, language = make_line(text, voice, Path(folder), console)
        animation = animate(alignment, rig="arkit_tongue", language=language)
        animation.save(output)
    words = [word.label for word in animation.words if word.label]
    seconds = len(animation.values) / animation.fps
    console.print(f"wrote {output}: {len(words)} words, {seconds:.1f} s, with sound")
    if view:
        open_page(output, console)
    console.print_result({"page": str(output), "words": words})


def make_line(text: str | None, voice: str, folder: Path, console: Console) -> tuple[Path, str]:
    """The alignment of the text, with its sound beside it, in a folder; and the language of its labels."""
    from phonanim.aligners.espeak import reading_language
    from phonanim.commands._speech import speak_text
    from phonanim.core.lexicon import LEXICON

    if text is not None:
        return speak_text(text, voice, folder / "demo", console), reading_language(voice)
    for suffix in (".TextGrid", ".wav"):
        shutil.copy(LEXICON / "demo" / f"line{suffix}", folder / f"demo{suffix}")
    return folder / "demo.TextGrid", "english"
