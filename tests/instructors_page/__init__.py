"""The instructors' page, followed literally: every shell command that it shows is run."""
