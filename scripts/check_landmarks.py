"""Mark the face of a head in headless Chromium, as a person would, and compare what is saved.

    python scripts/check_landmarks.py head.glb landmarks.csv -o work/check

Writes the page of `phonanim rig landmarks`, clicks with the mouse where the points of the table are seen, at
1280 and at 390 pixels, saves, and prints how far the saved points lie from those of the table as seen from
the front, in units of the file; the head looks along z, y up. Leaves the saved tables and pictures in the
output folder. Exit code 1, with one line, when the page misbehaves or a point is farther than `--within`.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np
from browser import Browser, open_browser

from phonanim.rig.character import load_character
from phonanim.rig.face_points import face_points
from phonanim.rig.landmarks import MeshLandmarks, read_landmarks
from phonanim.viewer.marking_page import write_marking_page

WITHIN = 0.002  # units of the file: two pixels on a small screen, of a head in metres


def mark(browser: Browser, spots: MeshLandmarks) -> None:
    """Click on every point, in the order in which the page asks for them."""
    for number, point in enumerate(face_points()):
        browser.value(f"choose({number})")
        one = spots.take([point.landmark])
        spot = json.dumps({"corners": one.corners[0].tolist(), "weights": one.weights[0].tolist()})
        browser.value(f"document.getElementById('{side(point.landmark)}').click()")
        time.sleep(0.3)
        x, y = browser.value(f"phonanim.pixel({spot})")
        box = browser.value("document.getElementById('stage').getBoundingClientRect().toJSON()")
        place = {"x": box["x"] + x, "y": box["y"] + y, "button": "left", "clickCount": 1}
        before = browser.value("phonanim.found.size")
        for kind in ("mousePressed", "mouseReleased"):
            browser.call("Input.dispatchMouseEvent", type=kind, **place)
        browser.wait(f"phonanim.found.size === {before + 1}")


def side(landmark: int) -> str:
    """The button of the side from which a point is seen."""
    return {234: "right", 454: "left"}.get(landmark, "front")


def try_page(browser: Browser, page: Path, width: int, spots: MeshLandmarks, folder: Path) -> Path:
    """Mark and save at a width of the window; return the saved table."""
    size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", **size)
    browser.call("Page.navigate", url=page.resolve().as_uri())
    browser.wait("document.documentElement?.dataset.drawn === '0'")
    browser.picture(folder / f"landmarks{width}_before.png")
    mark(browser, spots)
    browser.value("document.getElementById('front').click()")
    browser.wait("!document.getElementById('save').disabled")
    time.sleep(0.5)
    browser.picture(folder / f"landmarks{width}.png")
    saved = folder / f"{page.stem}.points.csv"
    saved.unlink(missing_ok=True)
    browser.click("save")
    end = time.monotonic() + 30
    while not saved.exists():
        if time.monotonic() > end:
            raise RuntimeError("nothing was saved")
        time.sleep(0.1)
    time.sleep(0.3)
    return saved.rename(folder / f"points{width}.csv")


def main() -> int:
    parser = argparse.ArgumentParser(description="Try the page of phonanim rig landmarks in Chromium.")
    parser.add_argument("head", type=Path)
    parser.add_argument("landmarks", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--within", type=float, default=WITHIN)
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    page = options.output / f"{options.head.stem}.html"
    write_marking_page(options.head, page)
    spots, points = read_landmarks(options.landmarks), load_character(options.head).vertices
    try:
        with open_browser(options.output) as browser:
            for width in (1280, 390):
                saved = read_landmarks(try_page(browser, page, width, spots, options.output))
                apart = saved.of(points) - spots.take(saved.numbers).of(points)
                apart = np.linalg.norm(apart[:, :2], axis=1)
                print(f"{width} pixels: {len(apart)} points, at most {apart.max():.4f} from where they were")
                if apart.max() > options.within:
                    raise RuntimeError(f"point {saved.numbers[apart.argmax()]} is too far")
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
