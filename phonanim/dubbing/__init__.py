"""Many lines: read, animated by many workers, remembered in a ledger, and reported on."""
