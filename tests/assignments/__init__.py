"""Right and wrong answers to every exercise, and the proof that the grader tells them apart."""
