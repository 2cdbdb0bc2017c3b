"""What others get of a course: archives of its assignments, and the course without its answers."""
