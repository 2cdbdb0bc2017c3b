from . import certificates as certificates
from . import cli as cli
from . import consistency as consistency
from . import descent as descent
from . import drawing as drawing
from . import estimators as estimators
from . import factors as factors
from . import files as files
from . import fleet as fleet
from . import graphs as graphs
from . import groups as groups
from . import incremental as incremental
from . import problems as problems
from . import progress as progress
from . import solver as solver
from .descent.marginals import covariance as covariance
from .drawing import draw_map as draw_map
from .files.reading import load as load
from .files.reading import read as read
from .files.writing import save as save
from .graphs.pose_graph import PoseGraph as PoseGraph
from .incremental.growing_map import GrowingMap as GrowingMap
from .solver import solve as solve

__version__: str
