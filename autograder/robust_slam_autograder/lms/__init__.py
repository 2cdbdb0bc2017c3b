"""Marks for a learning management system: rosters, late work, Canvas and Moodle."""
