"""Phones or audio as they arrive -> frames as they fall due."""
