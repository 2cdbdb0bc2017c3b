"""Hostile, broken and odd submissions of any assignment, and what must hold of their marks.

An assignment becomes a ``Target``; from it each ``Entry`` writes one submission's folder and says
how it is bound. ``batch`` grades them all at once and counts what went wrong.
"""
