"""Films for the tests of studies: half a second, 16 x 16 pixels, VP8 and silent Opus in WebM."""

import base64
import itertools

# Made with PyAV: five grey pictures at 10 fps (libvpx), 25 frames of silence at 48 kHz (libopus, 6 kbit/s).
FILM = base64.b64decode(
    """
GkXfo59ChoEBQveBAULygQRC84EIQoKEd2VibUKHgQRChYECGFOAZwEAAAAAAAQFEU2bdLpNu4tTq4QVSalmU6yBoU27i1OrhBZU
rmtTrIHYTbuMU6uEElTDZ1OsggGBTbuMU6uEHFO7a1OsggPv7AEAAAAAAABZAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA
AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAVSalmsirXsYMPQkBNgI1M
YXZmNjIuMTIuMTAyV0GNTGF2ZjYyLjEyLjEwMkSJiEB/wAAAAAAAFlSua0CjrgEAAAAAAAA114EBc8WIFIFOCz27YAmcgQAitZyD
dW5kiIEAhoVWX1ZQOIOBASPjg4QF9eEA4IawgRC6gRCuAQAAAAAAAFzXgQJzxYiOHrBly+IMQJyBACK1nIN1bmSIgQCGhkFfT1BV
U1aqg2MuoFa7hATEtACDgQLhkZ+BAbWIQOdwAAAAAABiZIEQY6KTT3B1c0hlYWQBATgBgLsAAAAAABJUw2dAjXNzoGPAgGfImkWj
h0VOQ09ERVJEh41MYXZmNjIuMTIuMTAyc3OyY8CLY8WIFIFOCz27YAlnyKFFo4hEVVJBVElPTkSHkzAwOjAwOjAwLjUwMDAwMDAw
MABzc7JjwItjxYiOHrBly+IMQGfIoUWjiERVUkFUSU9ORIeTMDA6MDA6MDAuNTA4MDAwMDAwAB9DtnVB1eeBAKOLggAAgAgL5jsj
q2Cjo4EAAIAQAgCdASoQABAAAEcIhYWIhYSIAgIADA1gAP7/q1CAo4qCABWACAissw7Go4qCACmACAissw7Go4qCAD2ACAissw7G
o4qCAFGACAissw7Go4qCAGWACAissw7Go5iBAGQAsQEACxFgABgAMCgv9AAgAP7YoACjioIAeYAICKyzDsajioIAjYAICKyzDsaj
ioIAoYAICKyzDsajioIAtYAICKyzDsajioIAyYAICKyzDsajmIEAyACxAQALEWAAGAAwKC/0ACAA/tsQAKOKggDdgAgIrLMOxqOK
ggDxgAgIrLMOxqOKggEFgAgIrLMOxqOKggEZgAgIrLMOxqOKggEtgAgIrLMOxqOYgQEsALEBAAsRYAAYADAoL/QAIAD+2KAAo4qC
AUGACAissw7Go4qCAVWACAissw7Go4qCAWmACAissw7Go4qCAX2ACAissw7Go4qCAZGACAissw7Go5iBAZAAsQEACxFgABgAMCgv
9AAgAP7bEACjioIBpYAICKyzDsajioIBuYAICKyzDsajioIBzYAICKyzDsajioIB4YAICKyzDsaglqGKggH1AAgIrLMOxpuBB3Wi
hADN/mAcU7trkbuPs4EAt4r3gQHxggIU8IEQ
"""
)


def film(number=0):
    """A film that differs from others by its number; what follows the last element is not played."""
    return FILM + b"\xec\x81" + bytes([number])  # an element called Void


def folders(root, systems=("ours", "other"), items=("a", "b", "c", "d", "e")):
    """One folder of films a system."""
    numbers = itertools.count()
    for system in systems:
        (root / system).mkdir(parents=True)
        for item in items:
            (root / system / f"{item}.webm").write_bytes(film(next(numbers)))
    return [root / system for system in systems]
