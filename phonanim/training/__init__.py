"""Training recipes become model folders."""
