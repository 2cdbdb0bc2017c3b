"""The students' page, followed literally."""
