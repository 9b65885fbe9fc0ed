"""Phones on a time grid become features for a regressor."""
