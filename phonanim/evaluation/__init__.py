"""Predictions against references: measures, scores and statistics."""
