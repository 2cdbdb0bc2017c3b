"""How far the measurements support a map, beyond that it is optimal for the closures it keeps.

A certificate is about the kept closures alone. Whether these are the inliers is another question.
The support is *unique* if no other set of closures that agree with each other explains what is
contested nearly as well, and no part of the map rests on a single place that nothing else
confirms. So it is false where such a set or such a part exists: ``rivals`` looks for both.

Source: MacKay 2003, chapter 28, for the comparison by evidence; the definition is derived here.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from scipy.special import betaln

from robust_slam._arrays import Mask
from robust_slam.solver.candidates import Candidate, Search
from robust_slam.solver.evidence import gains
from robust_slam.solver.misfit import NOTHING, Misfit, find_misfit
from robust_slam.solver.noise import rescaled
from robust_slam.solver.rivals import Contest, Lone, comparable, lone_places
from robust_slam.solver.slips import strayed


class Support(Enum):
    """What singles out a map.

    - UNIQUE: no rival is comparable, and no part of the map rests on one place.
    - AMBIGUOUS: rejected closures that agree explain what is contested nearly as well.
    - WEAK: a part rests on one place, or odometry alone has nearly as much evidence,
      or it slipped, or a step bends the map, or rejected closures are close to it, or no closure
      is kept, or the time did not suffice to look for a rival.
    """

    UNIQUE = "unique"
    AMBIGUOUS = "ambiguous"
    WEAK = "weak"


_DECISIVE = 30.0
"""So much evidence (nats) is enough, although many sets of closures were tried."""


_LEVEL = 1e-3
"""The probability below which chance does not explain what a map leaves.

In the same worlds all good maps but one have more than 0.04.
"""


@dataclass(frozen=True, eq=False)
class Judgement:
    """The support of a map, the edges ``(m,)`` that its rival keeps or None, and what misfits."""

    support: Support
    rival: Mask | None = None
    misfit: Misfit = NOTHING
    lone: tuple[Lone, ...] = ()


def judge_support(search: Search, best: Candidate, contests: Sequence[Contest]) -> Judgement:
    """Return the support of the map ``best`` of a ``search``, which is refined."""
    if np.any(search.slips) or not np.any(best.kept & ~search.trusted):
        return Judgement(Support.WEAK)
    if best.evidence < _DECISIVE and not _borne_out(search, best):
        return Judgement(Support.WEAK)
    rivals = comparable(contests)
    if rivals:
        return Judgement(Support.AMBIGUOUS, rivals[0].kept)
    if search.deadline.passed:
        return Judgement(Support.WEAK)
    misfit, lone = misfit_of(search, best), lone_places(search, best)
    weak = bool(misfit and (misfit.bent or misfit.closures.size)) or bool(lone)
    return Judgement(Support.WEAK if weak else Support.UNIQUE, misfit=misfit, lone=lone)


def misfit_of(search: Search, best: Candidate) -> Misfit:
    """Return what chance explains with less than the probability ``_LEVEL`` in a refined map."""
    astray = strayed(search)
    if astray is not None:
        return replace(NOTHING, step=astray)
    if search.learns and np.all(best.found == 1.0):
        # Noise that was not found explains nothing, and is no reason for doubt.
        return NOTHING
    precise = rescaled(search.graph, best.found)
    return find_misfit(precise, best.poses, best.kept, search.trusted, search.threshold, _LEVEL)


def _borne_out(search: Search, best: Candidate) -> bool:
    """Tell whether chance gives no set of as many closures so much evidence, and each adds some.

    What outliers measure is on average no more likely with a map than without it. By chance the
    evidence of a set of them therefore exceeds e with a probability of at most exp(-e), and that
    of any set with at most the number of sets times this.

    Source: Markov's inequality, for the likelihood ratio.
    """
    kept = best.kept & ~search.trusted
    count, size = int(np.sum(~search.trusted)), int(np.sum(kept))
    sets = -np.log(count + 1.0) - betaln(count - size + 1.0, size + 1.0)
    if best.evidence < sets - np.log(_LEVEL):
        return False
    precise = rescaled(search.graph, best.found)
    return bool(np.all(gains(precise, best.poses, best.kept, kept, search.entropy) > 0.0))
