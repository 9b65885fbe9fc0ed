"""The inputs of a line: alignment files and recordings, in the form that a model needs."""
