"""nbgrader's own configuration for this course: where things are, and who runs the tests.

nbgrader looks for it on Jupyter's configuration path, so put this folder there:
``JUPYTER_CONFIG_PATH=autograder nbgrader autograde 02-four-costs``, or
``jupyter lab`` likewise, where ``solutions`` is; elsewhere the course is the folder around this.
"""

import sys
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.nbgrader.own_files import read_warily
from robust_slam_autograder.nbgrader.settings import nbgrader_settings

root = Path.cwd() if Path("solutions").is_dir() else Path(__file__).resolve().parents[1]
try:
    layout.refuse_unmoved(layout.GRADED, root)
except WrongUse as error:
    sys.exit(str(error))
(root / layout.GRADED).mkdir(parents=True, exist_ok=True)  # SQLite makes the file alone
c = get_config()  # noqa: F821 (nbgrader defines it for this file)
c.merge(nbgrader_settings(str(root)))
read_warily()
