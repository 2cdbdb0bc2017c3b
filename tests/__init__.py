"""Tests mirror the tree: lib/, autograder/, book/, assignments/; the sample class is here too."""
