"""How films of real faces are tracked: their quality, what is refused, time and memory. No sound is needed.

    python benchmarks/track_films.py FILM...

Needs `phonanim[track]`. docs/own_speaker.md names packages that ship such films.
"""

from __future__ import annotations

import argparse
import resource
import time
from pathlib import Path

from phonanim.corpus.tracking import Tracker, measure_quality, mediapipe_tracker, shipped_indices, track_film
from phonanim.errors import CorpusError
from phonanim.media.video import open_film


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("films", type=Path, nargs="+", metavar="FILM")
    films, tracker = options.parse_args().films, mediapipe_tracker(shipped_indices())
    for path in films:
        try:
            print(f"{path.name}: {measured(path, tracker)}", flush=True)
        except CorpusError as error:
            print(f"refused: {error}", flush=True)
    print(f"largest memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


def measured(path: Path, tracker: Tracker) -> str:
    """One line of what a film is worth."""
    film, started = open_film(path), time.process_time()
    track = track_film(film, tracker)
    cost = (time.process_time() - started) / len(track.landmarks) * 1000
    worth = measure_quality(track.landmarks, tracker.indices)
    return (
        f"{len(track.landmarks)} frames at {float(film.rate):g}/s, {len(track.rejected)} bridged, "
        f"{worth.pupils_px:.0f} px between the pupils, jitter {worth.jitter_mm:.2f} mm, "
        f"turn {worth.turn_deg:.0f} degrees, {cost:.0f} ms of CPU a frame"
    )


if __name__ == "__main__":
    main()
