from .graphs.datasets import load as load
from .graphs.g2o import read as read
from .graphs.pose_graph import PoseGraph as PoseGraph
from .pipeline import solve as solve
