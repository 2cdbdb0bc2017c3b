"""Drawing functions of the course: axes in, axes out, no figure and no state of their own."""
