from . import se2 as se2
from . import se3 as se3
from .group import Group as Group
from .group import group_of as group_of
