"""Previews: the parts at the start of a run, as a picture or a page; nothing is run."""
