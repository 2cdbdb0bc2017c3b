from .landscapes import annealing as annealing
from .maps import opening as opening
from .readings import leverage as leverage
