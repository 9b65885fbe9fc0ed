"""HuBERT (Hsu et al. 2021): the input and every layer of its transformer, run by transformers."""

from __future__ import annotations

from phonanim.encoders._transformers import Hidden, load_hidden


def load() -> Hidden:
    """The encoder with the weights in its folder. Raises ModelError, which says how to get them."""
    return load_hidden("hubert", "HubertModel", "facebook/hubert-base-ls960")
