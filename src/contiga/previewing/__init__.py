"""Previews: the parts at the start of a run, as a picture or a page; nothing is run.

Question: does this model look as it was meant? Read `preview` (what users call), `stage` (what is
shown), `still` (the picture) with `words`, `page` (one HTML file), `routes`.
"""
