"""Watch the example page of examples/web in headless Chromium: it speaks with sound, and stops.

    cd examples/web && npm install three
    phonanim animate ../line.TextGrid -o line.glb -o line.track.json && cp ../line.wav .
    python ../../scripts/check_web.py . -o /tmp/check

Ends with status 1, and one line, when a shape is missing, or the face does not move or go back to rest.
"""

from __future__ import annotations

import argparse
import functools
import http.server
import sys
import threading
from pathlib import Path

from browser import Browser, open_browser

SMALL = {"width": 360, "height": 270, "deviceScaleFactor": 1, "mobile": False}  # software draws it in time
MOVED = 0.05  # of full weight
# Once the sound has played a second, note what the face does, interrupt it, and note when it is at rest.
WATCH = """globalThis.seen = { most: 0 };
const weights = () => [...face.shown].filter(([name]) => !name.startsWith("head")).map(([, value]) => value);
const most = () => Math.max(0, ...weights());
(function watch() {
  seen.most = Math.max(seen.most, most());
  if (seen.began && !most()) seen.rest = performance.now() - seen.began;
  if (!seen.began && face.line?.audio?.currentTime > 1) {
    seen.away = face.line.audio.currentTime - face.line.time;
    seen.began = performance.now();
    face.stop();
  }
  if (!seen.rest) requestAnimationFrame(watch);
})();"""


class Quiet(http.server.SimpleHTTPRequestHandler):
    """Serves a folder and prints nothing."""

    def log_message(self, *_: object) -> None:
        """Nothing."""


def watch(browser: Browser, address: str, picture: Path) -> None:
    """The page in Chromium. Raises RuntimeError."""
    browser.call("Emulation.setDeviceMetricsOverride", **SMALL)
    browser.call("Page.navigate", url=address)
    browser.wait("typeof face === 'object'")
    missing = browser.value("document.getElementById('state').value")
    if missing:
        raise RuntimeError(missing)
    browser.value(WATCH)
    browser.click("speak")
    browser.wait("seen.rest")
    seen = browser.value("seen")
    print(f"speaks: largest weight {seen['most']:.2f}; the sound is {1000 * seen['away']:.0f} ms ahead")
    print(f"interrupted: at rest after {seen['rest']:.0f} ms")
    browser.picture(picture)
    if seen["most"] < MOVED:
        raise RuntimeError("the face does not move")


def main() -> int:
    """Serve the folder and watch its page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    handler = functools.partial(Quiet, directory=options.folder)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        with open_browser(options.output) as browser:
            watch(browser, f"http://127.0.0.1:{server.server_address[1]}/", options.output / "web.png")
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
