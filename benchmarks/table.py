"""Results of evaluate.py as the Markdown tables of docs/results.md.

python benchmarks/table.py benchmarks/results.json
"""

from __future__ import annotations

import json
from pathlib import Path

import click

COLUMNS = {
    "test": {
        "vertex_error_mm": "vertex error, mm",
        "vertex_error_speech_mm": "in speech",
        "aperture_r": "aperture r",
        "aperture_r_speech": "in speech",
        "width_r": "width r",
        "width_r_speech": "in speech",
        "protrusion_r_speech": "protrusion r in speech",
        "pbm_gap_mm": "p b m gap, mm",
    },
    "words": {
        "aperture_r_in_clip": "aperture r, speech of the clips",
        "width_r_in_clip": "width r, speech of the clips",
        "aperture_r_in_word": "aperture r, withheld words alone",
        "width_r_in_word": "width r, withheld words alone",
    },
    "phones": {
        "aperture_r": "aperture r",
        "width_r": "width r",
        "aperture_r_ch": "CH",
        "aperture_r_jh": "JH",
        "aperture_r_th": "TH",
        "aperture_r_aw": "AW",
    },
    "ema": {"aperture_r_mean": "aperture r, mean", "aperture_r_1": "first", "aperture_r_2": "second"},
}
COLUMNS["validation"] = COLUMNS["oracle"] = COLUMNS["test"]


@click.command(help=__doc__)
@click.argument("results", type=click.Path(exists=True, path_type=Path))
def main(results: Path) -> None:
    """Print one table for each kind of measurement in the file."""
    for what, rows in json.loads(results.read_text(encoding="utf-8")).items():
        columns = COLUMNS[what]
        print(f"\n### {what}\n")
        print("| model | " + " | ".join(columns.values()) + " |")
        print("|---|" + "---:|" * len(columns))
        for name, row in rows.items():
            print(f"| {name} | " + " | ".join(f"{row[key]:.3f}" for key in columns) + " |")


if __name__ == "__main__":
    main()
