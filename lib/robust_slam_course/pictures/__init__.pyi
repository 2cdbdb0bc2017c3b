from .certificates import certificate as certificate
from .landscapes import annealing as annealing
from .landscapes import basins as basins
from .maps import cycles as cycles
from .maps import opening as opening
from .readings import kernels as kernels
from .readings import leverage as leverage
from .readings import majoriser as majoriser
