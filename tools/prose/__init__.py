"""Holds the course's language: proselint, and the project's own list of words.

``python -m tools.prose`` reads the pages, the assignments and the guides with both, and the
docstrings, comments and messages of the code with the list of words alone. It prints each finding
with its place, and ends with status 1 if there is one. ``proselint.toml`` says which of
proselint's checks are off and why, ``words.toml`` which words the course replaces.
"""
