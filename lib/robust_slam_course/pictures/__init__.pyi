from .maps import opening as opening
from .readings import leverage as leverage
