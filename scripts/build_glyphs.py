"""Build lexicon/glyphs/*.npz, the letters (IPA among them) that pictures are labelled with.

    pip install numpy pillow matplotlib
    python scripts/build_glyphs.py

The letters are drawn from DejaVu Sans, which matplotlib carries; its licence is copied beside them.
"""

from __future__ import annotations

import importlib.util
import shutil
import sys
import unicodedata
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

sys.path.insert(0, str(Path(__file__).parent.parent))

from phonanim.core.lexicon import LEXICON
from phonanim.exporters.npz import save_arrays

FACES = {"small": ("DejaVuSans.ttf", 12), "large": ("DejaVuSans-Bold.ttf", 17)}
# ASCII, Latin with accents, IPA and its modifiers, marks that combine, Greek, ties and punctuation.
RANGES = (
    (32, 126),
    (0xA0, 0x17F),
    (0x1CD, 0x1DC),
    (0x250, 0x2FF),
    (0x300, 0x36F),
    (0x391, 0x3C9),
    (0x2010, 0x203A),
)
ROOM = 32  # pixels to the left of a letter, for marks that reach back


def main() -> None:
    """Draw every letter at every size."""
    package = importlib.util.find_spec("matplotlib")
    if package is None or package.origin is None:
        sys.exit("matplotlib is not installed: pip install matplotlib")
    fonts = Path(package.origin).parent / "mpl-data" / "fonts" / "ttf"
    folder = LEXICON / "glyphs"
    shutil.copyfile(fonts / "LICENSE_DEJAVU", folder / "LICENSE")
    for name, (file, size) in FACES.items():
        draw(
            folder / f"{name}.npz",
            ImageFont.truetype(str(fonts / file), size, layout_engine=ImageFont.Layout.BASIC),
        )


def draw(path: Path, font: ImageFont.FreeTypeFont) -> None:
    """One strip of letters side by side, and where each is: code, first column, columns, shift, advance."""
    ascent, descent = font.getmetrics()
    rows, strips, at = [], [], 0
    missing = letter(font, "\uffff", ascent, descent).tobytes()
    for code in (c for low, high in RANGES for c in range(low, high + 1)):
        picture = letter(font, chr(code), ascent, descent)
        if unicodedata.category(chr(code)) in ("Cn", "Cc", "Cf") or picture.tobytes() == missing:
            continue
        inked = np.flatnonzero(picture.any(axis=0))
        first, last = (inked[0], inked[-1] + 1) if len(inked) else (ROOM, ROOM)
        advance = 0 if unicodedata.combining(chr(code)) else round(font.getlength(chr(code)))
        rows.append((code, at, last - first, first - ROOM, advance))
        strips.append(picture[:, first:last])
        at += last - first
    save_arrays(
        path, {"letters": np.array(rows, np.int32), "ink": np.hstack(strips), "ascent": np.int32(ascent)}
    )
    print(f"{path}: {len(rows)} letters, {path.stat().st_size} bytes")


def letter(font: ImageFont.FreeTypeFont, text: str, ascent: int, descent: int) -> np.ndarray:
    """One letter with its origin ROOM pixels from the left, (height, width) uint8."""
    image = Image.new("L", (ROOM * 3, ascent + descent))
    ImageDraw.Draw(image).text((ROOM, ascent), text, fill=255, font=font, anchor="ls")
    return np.asarray(image)


if __name__ == "__main__":
    main()
