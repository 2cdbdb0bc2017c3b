"""Python in the page: what ``make runtime`` collects in ``build/runtime``.

``pyodide/`` holds Pyodide's files, each with the checksum that ``pyodide.sha256`` lists;
``wheels/`` the course's packages and others that Pyodide lacks; ``lab/`` the assignments in
JupyterLab. The file ``.ready`` is written last: where it is, the runtime is complete.
"""
