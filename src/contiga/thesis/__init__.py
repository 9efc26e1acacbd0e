"""The thesis, reproduced: every experiment of it, run anew and set beside its own numbers."""
