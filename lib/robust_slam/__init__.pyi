from . import certificates as certificates
from . import cli as cli
from . import consistency as consistency
from . import descent as descent
from . import drawing as drawing
from . import estimators as estimators
from . import factors as factors
from . import fleet as fleet
from . import graphs as graphs
from . import incremental as incremental
from . import problems as problems
from . import progress as progress
from . import solver as solver
from .descent.marginals import covariance as covariance
from .drawing import draw_map as draw_map
from .graphs.files import load as load
from .graphs.files import save as save
from .graphs.pose_graph import PoseGraph as PoseGraph
from .graphs.reading import read as read
from .incremental.growing_map import GrowingMap as GrowingMap
from .solver import solve as solve

__version__: str
