"""What people read of results: pages, tables, Markdown and JSON."""
