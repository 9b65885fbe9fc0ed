"""Convert phones on a time grid into features for a regressor."""
