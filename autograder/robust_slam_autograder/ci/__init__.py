"""Grading where others run the machine: workflow files, and an autograder for Gradescope."""
