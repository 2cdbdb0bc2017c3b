"""What the site has beyond jupyter-book; ``_config.yml`` lists these modules."""
