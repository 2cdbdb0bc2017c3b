"""Tables that are computed once for the book's pictures and kept in the repository."""
