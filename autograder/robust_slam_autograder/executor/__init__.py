"""Trusted processes, sessions with untrusted ones, budgets, and the workers of a cluster."""
