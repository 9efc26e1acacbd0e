"""Damaged files for every reader: each is read, or refused with one clear message.

``python -m tests.fuzz --count 100000 --jobs 2`` runs the full size; `test_fuzz` a sample of it.
"""
