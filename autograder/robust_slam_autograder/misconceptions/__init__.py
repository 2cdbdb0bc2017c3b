"""Names the misconception behind a wrong answer, by the values that it returns."""
