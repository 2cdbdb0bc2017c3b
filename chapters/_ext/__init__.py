"""What the site has beyond jupyter-book; ``_config.yml`` lists these modules."""

from pathlib import Path

from jinja2 import Environment, FileSystemLoader

TEMPLATES = Environment(
    loader=FileSystemLoader(Path(__file__).parents[1] / "_templates"), autoescape=True
)
"""What these modules write into pages; Sphinx itself finds there what pages are made of."""
