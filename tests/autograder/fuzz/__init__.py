"""Hostile bytes for whatever the trusted side reads: messages, frames, notebooks, texts of cells.

Each test tries many inputs, and twenty times as many in ``make soak``. What must hold of all
of them: no crash, no hang, nothing but the errors that are promised.
"""
