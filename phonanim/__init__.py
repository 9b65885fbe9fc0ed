"""Speech animation from phone alignments: a Praat TextGrid and a rig in, moving lips out."""

__version__ = "0.1.0"
