"""Streaming: phones or audio in as they arrive, animation frames out in real time."""
