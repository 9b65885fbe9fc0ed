"""The nouns of speech: alignments, tiers, phones, the inventory and the languages."""
