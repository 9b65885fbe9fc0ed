"""Recordings with known words become alignments."""
