"""What both sides of a conversation run: its messages, and the notebook that runs cells."""
