"""How far ARKit's lips pucker in /y/ by language, with the language's own rounding and without it.

    python benchmarks/rounding.py

eSpeak NG (phonanim[espeak]) speaks a short line of each language. Prints the largest mouthPucker in the
middle of a /y/: with the `rounding` of the language file, and with its inverse as --rounding, so without it.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import phonanim
from phonanim.aligners.espeak import reading_language, speak
from phonanim.speech.language_files import load_language
from phonanim.speech.textgrid import write_textgrid

LINES = {
    "fr": "Tu as vu la lune.",
    "de": "Die Tür ist grün und müde.",
    "fi": "Hyvä yö, kylä.",
    "sv": "Ny yta, flyta.",
    "tr": "Gün, süt, üzüm.",
}


def main() -> None:
    """Print the table."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    print("| language | with | without |\n|---|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for voice, text in LINES.items():
            spoken = speak(text, voice)
            path = Path(folder) / f"{voice}.TextGrid"
            write_textgrid(path, {"words": spoken.words, "phones": spoken.phones}, spoken.duration)
            language = reading_language(voice)
            own = load_language(language).rounding
            print(f"| {language} | {pucker(path, language, 1):.2f} | {pucker(path, language, 1 / own):.2f} |")


def pucker(path: Path, language: str, rounding: float) -> float:
    """The largest mouthPucker in the middle of a /y/ of a line."""
    animation = phonanim.animate(path, rig="arkit", language=language, rounding=rounding, life=0)
    curve = animation.channel("mouthPucker")
    middles = [(one.start + one.end) / 2 for one in animation.phones if "y" in one.label or "ʏ" in one.label]
    return max(float(curve[round(middle * animation.fps)]) for middle in middles)


if __name__ == "__main__":
    main()
