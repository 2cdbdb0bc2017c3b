"""What the pages of a built site weigh, cost and show, measured in Chromium."""
