"""Electromagnetic articulography: sensors on the tongue, the jaw and the lips.

`readers` read files of sensors, `preparation` and `posture` bring them to one rate and one head position,
`measures` and `examples` measure them in speech, `report` writes the results. docs/ema.md describes the use.
"""

from phonanim.ema.articulation import Articulation
from phonanim.ema.utterances import Utterance, load_utterances

__all__ = ["Articulation", "Utterance", "load_utterances"]
