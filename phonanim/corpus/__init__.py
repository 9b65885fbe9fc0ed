"""Recordings of a speaker become training pairs."""
