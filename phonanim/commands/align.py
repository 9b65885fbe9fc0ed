"""`phonanim align`: align speech with its text, and write a TextGrid."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from phonanim.commands import Console, console_options

if TYPE_CHECKING:
    from phonanim.aligners.pocketsphinx import SpeechAlignment


@click.command()
@click.argument("audio", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--text", help="The spoken text; recognized from the audio by default.")
@click.option(
    "--text-file",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="A UTF-8 file with the spoken text.",
)
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="TextGrid to write.")
@click.option(
    "--aligner",
    type=click.Choice(["pocketsphinx", "espeak", "mfa"]),
    help="pocketsphinx (phonanim[align]) is for English, espeak (phonanim[espeak]) for any language with a "
    "voice, mfa is an installed Montreal Forced Aligner; espeak with --voice, else pocketsphinx, by default.",
    show_default=False,
)
@click.option("--voice", help="Language of the speech for --aligner espeak: a code, such as de.")
@click.option("--mfa-model", metavar="NAME", help="Acoustic model of MFA; english_us_arpa by default.")
@click.option(
    "--mfa-dictionary", metavar="NAME", help="Dictionary of MFA; by default the one named like the model."
)
@console_options
def command(
    audio: Path,
    text: str | None,
    text_file: Path | None,
    output: Path | None,
    aligner: str | None,
    voice: str | None,
    mfa_model: str | None,
    mfa_dictionary: str | None,
    console: Console,
) -> None:
    """Find the words and phones of speech, offline, and write them as a TextGrid.

    Without -o, the TextGrid is written beside the recording. The language is English; for other languages
    give --voice, or use --aligner mfa with a model. Recordings other than 16-bit WAV need phonanim[audio].

    \b
    Examples:
      phonanim align speech.wav --text "The quick brown fox."
      phonanim align speech.wav --text-file speech.txt -o speech.TextGrid
      phonanim align rede.wav --text "Guten Morgen." --voice de
      phonanim align rede.wav --text "Guten Morgen." --aligner mfa --mfa-model german_mfa
    """
    from phonanim.errors import OptionError
    from phonanim.speech.textgrid import write_textgrid

    if text is not None and text_file is not None:
        raise OptionError("--text and --text-file both give the spoken text; use one")
    if text_file is not None:
        text = read_text(text_file)
    if aligner != "mfa" and (mfa_model or mfa_dictionary):
        raise OptionError("--mfa-model and --mfa-dictionary are for --aligner mfa; add it, or drop them")
    if voice is not None and aligner not in (None, "espeak"):
        raise OptionError("--voice is for --aligner espeak; add it, or drop the voice")
    if aligner == "espeak" or voice is not None:
        found = align_with_espeak(audio, text, voice)
    elif aligner == "mfa":
        found = align_with_mfa(audio, text, mfa_model, mfa_dictionary)
    else:
        found = align_english(audio, text, console)
    target = output or audio.with_suffix(".TextGrid")
    write_textgrid(target, found.tiers, found.duration)
    console.print(f"read {audio}: {found.duration:.2f} s" + ("" if text else ", words recognized"))
    console.print(f"found {len(found.words)} words, {len(found.phones)} phones")
    console.print(f"wrote {target}")
    for note in found.notes:
        console.print(f"note: {note}")
    words = " ".join(word.label for word in found.words)
    facts = {"textgrid": str(target), "words": words, "phones": len(found.phones), "seconds": found.duration}
    sure = [{"start": one.start, "end": one.end, "confidence": float(one.label)} for one in found.confidence]
    console.print_result({**facts, "confidence": sure, "notes": list(found.notes)})


def align_english(audio: Path, text: str | None, console: Console) -> SpeechAlignment:
    """Align English; without text, the words are those of Whisper if it is there, else of pocketsphinx."""
    from phonanim.aligners.long import align_recording
    from phonanim.aligners.pocketsphinx import align
    from phonanim.aligners.whisper import can_recognize
    from phonanim.commands._speech import understand

    said = None
    if text is None and can_recognize():
        text, said = understand(audio, None, console)
    return align(audio, None) if text is None else align_recording(audio, text, None, said)[0]


def align_with_espeak(audio: Path, text: str | None, voice: str | None) -> SpeechAlignment:
    """Align with speech that eSpeak NG makes of the text. Raises OptionError without text."""
    from phonanim.aligners.espeak import VOICE
    from phonanim.aligners.long import align_recording
    from phonanim.errors import OptionError

    if text is None:
        raise OptionError("--aligner espeak needs the spoken words; give them with --text or --text-file")
    return align_recording(audio, text, voice or VOICE)[0]


def align_with_mfa(
    audio: Path, text: str | None, model: str | None, dictionary: str | None
) -> SpeechAlignment:
    """Align with an installed Montreal Forced Aligner."""
    from phonanim.aligners import mfa

    return mfa.align(audio, text, model or mfa.MODEL, dictionary)


def read_text(path: Path) -> str:
    """The text of a file. Raises OptionError when it is not UTF-8."""
    from phonanim.core.decode import MAX_TEXT, DecodeError, read_utf8
    from phonanim.errors import OptionError

    try:
        return read_utf8(path, MAX_TEXT).removeprefix("\ufeff")
    except DecodeError as error:
        raise OptionError(f"{path}: {error}; save it as UTF-8") from error
