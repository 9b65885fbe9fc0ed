"""Recognize phones in sound: mel spectra, a small causal network, and the path through its phones."""
