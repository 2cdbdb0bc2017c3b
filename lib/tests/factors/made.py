"""A factor graph with every kind of factor, and the same in GTSAM."""

import numpy as np
from robust_slam.factors import FactorGraph, Factors
from robust_slam.graphs import sphere
from robust_slam.groups import se3

from ..worlds import random_graph, random_information


def roots(count, d, rng):
    root = rng.normal(size=(count, d, d))
    return root @ np.swapaxes(root, 1, 2) + np.eye(d)


def everything(group, seed, error=1.0, n=6):
    """A graph of n poses and 3 landmarks with all kinds of factors, and its map."""
    rng, d = np.random.default_rng(seed), group.DIMENSION
    poses, relative = random_graph(seed, group, n=n, m=n + 3, residual=error)
    places = rng.uniform(-4.0, 4.0, (3, d))
    x = np.concatenate([poses, group.from_parts(np.eye(d), places)])
    at = group.translation(x)

    def off(*shape):
        return error * rng.uniform(-1.0, 1.0, shape)

    priors, fixed = np.array([0, 3]), np.array([1, 2, 4, n + 1])
    seen = np.array([[i, n + k] for i in range(n) for k in range(3)] + [[0, 2], [4, 1]])
    far = np.array([[0, n], [n + 1, 2], [1, 5], [n, n + 2]])
    turn = np.swapaxes(group.rotation(x), 1, 2)[seen[:, 0]]
    point = (turn @ (at[seen[:, 1]] - at[seen[:, 0]])[..., None])[..., 0]
    distance = np.linalg.norm(at[far[:, 1]] - at[far[:, 0]], axis=1)
    graph = FactorGraph(
        relative=relative,
        landmarks=3,
        priors=Factors(
            priors,
            group.compose(poses[priors], group.exp(off(2, group.DOF))),
            random_information(group, 2, rng),
        ),
        positions=Factors(fixed, at[fixed] + off(4, d), roots(4, d, rng)),
        points=Factors(seen, point + off(len(seen), d), roots(len(seen), d, rng)),
        ranges=Factors(
            far, np.abs(distance + 0.3 * off(len(far))), rng.uniform(1.0, 9.0, len(far))
        ),
    )
    return graph, x


class Twin:
    """The factor graph in GTSAM: key k is node k, and the factors have their order."""

    def __init__(self, gtsam, graph):
        self.gtsam, self.graph = gtsam, graph
        self.plane = graph.group.DIMENSION == 2
        self.factors = gtsam.NonlinearFactorGraph()
        for block in graph.blocks:
            ends = block.ends.tolist()
            for (i, j), z, root in zip(ends, block.measurement, block.root, strict=True):
                self.factors.add(self.factor(block.name, i, j, z, root))

    def factor(self, name, i, j, z, root):
        gtsam = self.gtsam
        if name in ("relative", "priors"):
            order = np.arange(len(root)) if self.plane else np.array([3, 4, 5, 0, 1, 2])
            noise = self.noise((root.T @ root)[np.ix_(order, order)])
            pose, kind = self.pose(z), "Pose2" if self.plane else "Pose3"
            if name == "priors":
                return getattr(gtsam, f"PriorFactor{kind}")(j, pose, noise)
            return getattr(gtsam, f"BetweenFactor{kind}")(i, j, pose, noise)
        noise = self.noise(root.T @ root)
        if name == "ranges":
            kinds = [self.is_pose(i), self.is_pose(j)]
            near, far = (j, i) if kinds == [False, True] else (i, j)
            which = {2: "Pose", 1: "", 0: ""}[sum(kinds)]
            kind = f"{which}{'2' if self.plane else '3'}{'' if which or not sum(kinds) else 'D'}"
            return getattr(gtsam, f"RangeFactor{kind}")(near, far, float(z[0]), noise)
        if name == "positions" and not self.is_pose(j):
            return getattr(gtsam, f"PriorFactorPoint{2 if self.plane else 3}")(j, z, noise)
        if name == "positions":
            return (gtsam.PoseTranslationPrior2D if self.plane else gtsam.GPSFactor)(
                *((j, self.gtsam.Pose2(z[0], z[1], 0.0)) if self.plane else (j, z)), noise
            )
        return gtsam.CustomFactor(noise, [i, j], lambda _, x, h: self.seen(i, j, z, x, h))

    def seen(self, i, j, z, values, h):
        """The error of a point, with the derivatives of GTSAM's own transformTo."""
        d, dof = self.graph.group.DIMENSION, self.graph.group.DOF
        pose = values.atPose2(i) if self.plane else values.atPose3(i)
        by_pose, by_point = np.zeros((d, dof), order="F"), np.zeros((d, d), order="F")
        if self.is_pose(j):
            other = values.atPose2(j) if self.plane else values.atPose3(j)
            place, chain = other.translation(), np.zeros((d, dof))
            chain[:, :d] = other.rotation().matrix()
            chain = chain if self.plane else np.roll(chain, 3, axis=1)
        else:
            place, chain = values.atPoint2(j) if self.plane else values.atPoint3(j), np.eye(d)
        found = pose.transformTo(place, by_pose, by_point)
        if h is not None:
            h[0], h[1] = by_pose, by_point @ chain
        return found - z

    def noise(self, information):
        return self.gtsam.noiseModel.Gaussian.Information(information)

    def is_pose(self, node):
        return node < self.graph.n

    def pose(self, z):
        if self.plane:
            return self.gtsam.Pose2(*z)
        return self.gtsam.Pose3(np.vstack([z, [0.0, 0.0, 0.0, 1.0]]))

    def values(self, x):
        values = self.gtsam.Values()
        for k, pose in enumerate(x):
            place = self.graph.group.translation(pose)
            values.insert(k, self.pose(pose) if self.is_pose(k) else place)
        return values


def error(graph, x, truth):
    """The root mean square of the errors of positions (m), in the frame of the map."""
    off = graph.group.translation(x[: graph.n]) - graph.group.translation(truth[: graph.n])
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def flight(seed, n=120, trees=20, beacons=3):
    """A flight around a sphere with landmarks, GPS, ranges to beacons, and outliers in each."""
    rng = np.random.default_rng(seed)
    drive, way = sphere(n, rng, radius=15.0, closures=0)
    truth = se3.compose(se3.exp([50.0, 20.0, 3.0, 0.3, 0.2, 1.0]), way)
    at = se3.translation(truth)
    place = at[rng.choice(n, trees + beacons, replace=False)]
    place = place + rng.normal(size=place.shape)
    apart = place - at[:, None]
    pose, tree = np.nonzero(np.linalg.norm(apart[:, :trees], axis=2) < 8.0)
    turn = np.swapaxes(se3.rotation(truth), 1, 2)[pose]
    seen = (turn @ apart[pose, tree][..., None])[..., 0] + 0.1 * rng.normal(size=(pose.size, 3))
    fixed = np.arange(0, n, 4)
    fix = at[fixed] + 0.5 * rng.normal(size=(fixed.size, 3))
    near, beacon = np.nonzero(np.linalg.norm(apart[:, trees:], axis=2) < 20.0)
    far = np.linalg.norm(apart[near, trees + beacon], axis=1) + 0.2 * rng.normal(size=near.size)
    wrong = [rng.random(k) < 0.15 for k in (fixed.size, pose.size, near.size)]
    fix[wrong[0]] += 10.0 * rng.normal(size=(wrong[0].sum(), 3))
    seen[wrong[1]] += rng.choice([-3.0, 3.0], (wrong[1].sum(), 3))
    far[wrong[2]] += rng.uniform(3.0, 9.0, wrong[2].sum())
    graph = FactorGraph(
        relative=drive,
        landmarks=trees + beacons,
        positions=Factors(fixed, fix, 4.0 * np.eye(3)),
        points=Factors(np.stack([pose, n + tree], axis=1), seen, 100.0 * np.eye(3)),
        ranges=Factors(np.stack([near, n + trees + beacon], axis=1), np.abs(far), 25.0),
    )
    x = np.concatenate([truth, se3.from_parts(np.eye(3), place)])
    return graph, x, np.concatenate([np.zeros(n - 1, dtype=bool), *wrong])
