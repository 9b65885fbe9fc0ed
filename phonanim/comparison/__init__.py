"""The comparison: models trained and measured on the same clips, with intervals and tests."""
