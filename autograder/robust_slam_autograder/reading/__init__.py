"""Reads what instructors and students hand in: notebooks, their cells, and what of them counts."""
