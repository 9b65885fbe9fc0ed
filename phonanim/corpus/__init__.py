"""Convert the recordings of a speaker into training pairs."""
