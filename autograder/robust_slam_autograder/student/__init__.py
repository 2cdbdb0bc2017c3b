"""The student's process: what runs there, what it may import, what crosses to the grader."""
