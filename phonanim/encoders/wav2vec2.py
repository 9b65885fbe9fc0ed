"""wav2vec 2.0 (Baevski et al. 2020): the input and every layer of its transformer, run by transformers."""

from __future__ import annotations

from phonanim.encoders._transformers import Hidden, load_hidden


def load() -> Hidden:
    """The encoder with the weights in its folder. Raises ModelError, which says how to get them."""
    return load_hidden("wav2vec2", "Wav2Vec2Model", "facebook/wav2vec2-base")
