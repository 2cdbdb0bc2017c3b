"""Runs the notebooks that have changed before their pages are read, as many at once as cores.

MyST-NB runs one after the other. What ran here is in its cache, where it finds it. A notebook that
fails is left to MyST-NB, which runs it again and reports the cell.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import nbformat
from jupyter_cache import get_cache
from jupyter_cache.base import CacheBundleIn, JupyterCacheAbstract
from jupyter_cache.executors.utils import ExecutionResult, single_nb_execution
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util import logging

LOGGER = logging.getLogger(__name__)


def execute(app: Sphinx, env: BuildEnvironment, pages: list[str]) -> None:
    """Run the notebooks among the pages that are about to be read and put them into the cache."""
    config = env.mystnb_config
    if config.execution_mode != "cache":
        return
    cache = get_cache(config.execution_cache_path)
    paths = (Path(env.doc2path(page)) for page in pages)
    changed = _changed((path for path in paths if path.suffix == ".ipynb"), cache)

    def run(path: Path) -> ExecutionResult:
        return single_nb_execution(
            changed[path],
            cwd=str(path.parent),
            timeout=config.execution_timeout,
            allow_errors=config.execution_allow_errors,
        )

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        running = {pool.submit(run, path): path for path in changed}
        for done in as_completed(running):
            _keep(running[done], done.result(), cache)


def _changed(
    paths: Iterable[Path], cache: JupyterCacheAbstract
) -> dict[Path, nbformat.NotebookNode]:
    """The notebooks that the cache does not hold."""
    found = {}
    for path in paths:
        notebook = nbformat.read(path, as_version=4)
        try:
            cache.match_cache_notebook(notebook)
        except KeyError:
            found[path] = notebook
    return found


def _keep(path: Path, result: ExecutionResult, cache: JupyterCacheAbstract) -> None:
    """Put a notebook that ran to its end into the cache."""
    if result.err is not None:
        return
    LOGGER.info("%s: Executed notebook in %.2f seconds", path, result.time)
    staged = cache.add_nb_to_project(str(path))
    data = {"execution_seconds": result.time}
    bundle = CacheBundleIn(result.nb, staged.uri, data=data)
    cache.cache_notebook_bundle(bundle, check_validity=False, overwrite=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build."""
    app.connect("env-before-read-docs", execute)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
