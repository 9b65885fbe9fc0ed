"""Electromagnetic articulography: sensors on the tongue, the jaw and the lips.

`readers` read files of sensors, `preparation` and `posture` bring them to one rate and one head,
`measures` and `examples` say what they do in speech, `report` writes it down. docs/ema.md has the use.
"""

from phonanim.ema.articulation import Articulation
from phonanim.ema.utterances import Utterance, load_utterances

__all__ = ["Articulation", "Utterance", "load_utterances"]
