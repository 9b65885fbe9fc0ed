"""Animate many lines: read them, animate them with several workers, record them in a ledger, report."""
