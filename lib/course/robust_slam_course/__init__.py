"""What teaching adds to the library: styles, plots, live pictures, quizzes, exercise pictures."""
