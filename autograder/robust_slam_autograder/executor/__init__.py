"""Trusted and untrusted processes, and the pipe of plain data between them."""
