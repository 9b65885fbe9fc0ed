"""What a line is made from: alignment files and recordings, as a model needs them."""
