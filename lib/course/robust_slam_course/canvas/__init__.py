"""Live pictures: what the reader takes hold of, on a page and in a notebook.

``picture`` is what Python knows of one, ``bundle`` joins the modules of its script, which are
in ``js``: ``solve`` computes, ``draw`` draws, ``pictures`` holds one module for each picture.
"""
