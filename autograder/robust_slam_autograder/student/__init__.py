"""The student's process: what runs there, and what it may import."""
