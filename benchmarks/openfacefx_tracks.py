"""Animate alignments with OpenFaceFX, for benchmarks/tools.py; runs in an environment of its own.

    python -m venv work/openfacefx && work/openfacefx/bin/pip install openfacefx==0.24.0
    work/openfacefx/bin/python benchmarks/openfacefx_tracks.py RECORDINGS -o work/openfacefx_tracks

Reads the test clips that clips.csv of the recordings names, and writes one OpenFaceFX track per TextGrid:
the tool's own settings, its own map to ARKit shapes, keys from 60 frames per second.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("recordings", type=Path)
    options.add_argument("-o", "--output", type=Path, required=True)
    chosen = options.parse_args()
    from openfacefx.alignment import load_mfa_textgrid  # after --help, which needs no environment of its own
    from openfacefx.io_export import write_json
    from openfacefx.pipeline import generate_from_alignment
    from openfacefx.retarget import PRESETS, retarget

    chosen.output.mkdir(parents=True, exist_ok=True)
    with (chosen.recordings / "clips.csv").open(newline="", encoding="utf-8") as file:
        clips = [row["clip"] for row in csv.DictReader(file) if row["split"] == "test"]
    for clip in clips:
        segments = load_mfa_textgrid(str(chosen.recordings / "textgrid" / f"{clip}.TextGrid"))
        track = retarget(generate_from_alignment(segments), PRESETS["arkit"])
        write_json(track, str(chosen.output / f"{clip}.track.json"))


if __name__ == "__main__":
    main()
