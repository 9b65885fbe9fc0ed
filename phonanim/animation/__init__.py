"""Curves of controls: keys, smoothing, style, overlays, edits and timecode."""
