"""Texts that can be printed and stored, whatever they came from."""

from __future__ import annotations


def printable(text: str) -> str:
    """A text that can be written as UTF-8: bytes of file names that are none are shown by their codes."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")
