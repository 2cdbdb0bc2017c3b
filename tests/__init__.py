"""The course's tests; those of library and grader are beside them."""
