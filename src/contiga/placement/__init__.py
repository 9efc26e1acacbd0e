"""Where parts stand before a run: put at a gap from one another, aligned, and how near they are."""
