from .chordal import chordal_cost as chordal_cost
from .optimality import Certificate as Certificate
from .optimality import Verdict as Verdict
from .optimality import certificate as certificate
from .optimality import certify as certify
from .staircase import solve_certified as solve_certified
