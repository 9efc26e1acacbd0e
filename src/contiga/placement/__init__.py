"""Place parts before a run, at a gap or aligned, and measure how near they are.

Question: how far must a part move to stand at a given gap from another? Read `align` and `place`
(what users call), `pair` (gaps of two parts), `approach` (along a line), `sample`.
"""
