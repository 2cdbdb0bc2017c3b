"""How well one colour shows on another, by WCAG 2.1."""

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import ArrayLike


def luminance(colour: str | ArrayLike) -> float:
    """Return the relative luminance of a colour's name or of red, green and blue up to 1."""
    parts = np.array(to_rgb(colour) if isinstance(colour, str) else colour)
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one: float, other: float) -> float:
    """Return the contrast of two luminances, from 1 to 21."""
    low, high = sorted((one, other))
    return (high + 0.05) / (low + 0.05)
