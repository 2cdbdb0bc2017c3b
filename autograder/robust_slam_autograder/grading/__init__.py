"""Marks: one submission, a batch of them, and the files that a batch leaves behind."""
