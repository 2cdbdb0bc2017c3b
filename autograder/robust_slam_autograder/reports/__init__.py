"""What people read of a result: words, pages, Markdown, JSON and text for a terminal."""
