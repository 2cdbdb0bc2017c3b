from .growing_map import GrowingMap as GrowingMap
