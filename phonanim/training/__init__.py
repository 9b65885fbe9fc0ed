"""Train model folders from training recipes."""
