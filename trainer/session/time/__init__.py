"""The deadlines of the ticks, and the ledger of how they were kept."""
