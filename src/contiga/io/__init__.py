"""Files: each format reads into or writes from plain records."""
