"""Workflow files and the archive for Gradescope: linted, and their commands run."""
