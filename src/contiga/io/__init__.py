"""One file a format; each reads into or writes from plain records."""
