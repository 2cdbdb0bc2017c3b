from .rounds import Fleet as Fleet
