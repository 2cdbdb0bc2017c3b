from .factor_graph import FactorGraph as FactorGraph
from .factor_graph import Factors as Factors
from .generate import park as park
from .problem import FactorGraphProblem as FactorGraphProblem
from .reading import read_factors as read_factors
from .solve import FactorAnswer as FactorAnswer
from .solve import solve_factors as solve_factors
