"""Place parts before a run, at a gap or aligned, and measure how near they are."""
