"""Forced aligners: make alignments of recordings whose words are known."""
