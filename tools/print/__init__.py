"""The whole book as one PDF, printed by Chromium from the built pages."""
