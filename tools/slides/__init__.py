"""Slides for the lecture hall, cut from the built pages by marks in the chapters' sources."""
