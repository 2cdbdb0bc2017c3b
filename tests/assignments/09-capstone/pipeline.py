"""Answers to exercise pipeline of 09-capstone: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_indices() -> None:
    """Right: indices of the edges that are left after each stage."""
    import numpy as np

    def pipeline(graph, gamma, c, tools):
        def part(used):
            return {
                "n": graph["n"],
                "edges": graph["edges"][used],
                "measurement": graph["measurement"][used],
                "information": graph["information"][used],
                "is_odometry": graph["is_odometry"][used],
            }

        m = len(graph["edges"])
        steps = np.flatnonzero(graph["is_odometry"])
        steps = steps[np.argsort(graph["edges"][steps, 0])]
        loops = np.array([k for k in range(m) if not graph["is_odometry"][k]], dtype=int)
        cov = np.linalg.inv(graph["information"])
        agree = tools["pairwise_consistent"](
            graph["measurement"][steps],
            cov[steps],
            graph["edges"][loops],
            graph["measurement"][loops],
            cov[loops],
            gamma,
        )
        members = np.array(tools["largest_consistent_set"](agree), dtype=int)
        first = np.sort(np.append(steps, loops[members]))
        poses, weights = tools["robust_solve"](part(first), c)
        last = first[np.asarray(weights) > 0.5]
        kept = np.isin(np.arange(m), last)
        poses = tools["polish"](part(kept), poses)
        verdict, gap = tools["certificate"](part(kept), poses)
        return {"poses": poses, "kept": kept, "verdict": verdict, "gap": gap}


def right_masks() -> None:
    """Right: masks over the whole graph, and a solve for the covariances."""
    import numpy as np

    def pipeline(graph, gamma, c, tools):
        own, m = np.array(graph["is_odometry"], dtype=bool), len(graph["edges"])

        def thinned(keep):
            return {k: v if k == "n" else np.array(v)[keep] for k, v in graph.items()}

        order = np.argsort(np.where(own, graph["edges"][:, 0], graph["n"] + m), kind="stable")
        way = order[: graph["n"] - 1]
        unit = np.broadcast_to(np.eye(3), (m, 3, 3))
        covariance = np.linalg.solve(graph["information"], unit)
        loops = thinned(~own)
        table = tools["pairwise_consistent"](
            graph["measurement"][way],
            covariance[way],
            loops["edges"],
            loops["measurement"],
            covariance[~own],
            gamma,
        )
        chosen = list(tools["largest_consistent_set"](table))
        number = np.cumsum(~own) - 1
        kept = own | np.isin(number, chosen)
        poses, weights = tools["robust_solve"](thinned(kept), c)
        full = np.zeros(m)
        full[kept] = weights
        kept = own | (full > 0.5)
        answer = {"kept": kept.tolist(), "poses": tools["polish"](thinned(kept), poses)}
        answer["verdict"], answer["gap"] = tools["certificate"](thinned(kept), answer["poses"])
        return answer


def right_plain_lists() -> None:
    """Right: plain loops over edges, arrays only where a graph wants them."""
    import numpy as np

    def pipeline(graph, gamma, c, tools):
        edges = [tuple(int(v) for v in edge) for edge in graph["edges"]]
        own = [bool(v) for v in graph["is_odometry"]]
        covariance = [np.linalg.inv(omega) for omega in graph["information"]]
        at = {edge: k for k, edge in enumerate(edges) if own[k]}
        way = [at[k, k + 1] for k in range(graph["n"] - 1)]
        loops = [k for k in range(len(edges)) if not own[k]]

        def rows(values, chosen):
            return [values[k] for k in chosen]

        def graph_of(chosen):
            names = ("edges", "measurement", "information", "is_odometry")
            return {"n": graph["n"]} | {name: graph[name][list(chosen)] for name in names}

        z = graph["measurement"]
        table = tools["pairwise_consistent"](
            rows(z, way),
            rows(covariance, way),
            rows(edges, loops),
            rows(z, loops),
            rows(covariance, loops),
            gamma,
        )
        members = {loops[int(k)] for k in tools["largest_consistent_set"](table)}
        left = [k for k in range(len(edges)) if own[k] or k in members]
        poses, weights = tools["robust_solve"](graph_of(left), c)
        left = [k for k, w in zip(left, weights) if w > 0.5]
        poses = tools["polish"](graph_of(left), poses)
        verdict, gap = tools["certificate"](graph_of(left), poses)
        kept = [k in left for k in range(len(edges))]
        return {"poses": poses, "kept": kept, "verdict": verdict, "gap": gap}


wrong_information_for_covariance = change(
    right_indices, "cov = np.linalg.inv", "cov = np.array", stopped_by="pipeline-by-hand"
)
"""Wrong: hands the information over as a covariance."""

wrong_members_count_edges = change(
    right_indices, "loops[members]", "members", stopped_by="pipeline-by-hand"
)
"""Wrong: takes the members of the set for numbers of edges."""

wrong_filter_skipped = change(
    right_indices, "(part(first), c)", "(part(np.arange(m)), c)", stopped_by="pipeline-by-hand"
)
"""Wrong: solves all edges, as if the consistent set had never been asked for."""

wrong_limits_swapped = change(
    right_indices,
    ("cov[loops],\ngamma,", "cov[loops],\nc,"),
    ("part(first), c", "part(first), gamma"),
    caught_by="pipeline-passed-on",
)
"""Wrong: gamma for the solver and c for the pairs."""

wrong_any_weight = change(right_indices, "> 0.5", "> 0", stopped_by="pipeline-by-hand")
"""Wrong: keeps every closure whose weight is not zero."""

wrong_full_weight_only = change(right_indices, "> 0.5", ">= 1", caught_by="pipeline-passed-on")
"""Wrong: keeps closures of weight 1 alone."""

wrong_certifies_the_whole = change(
    right_indices,
    ('tools["certificate"](part(kept), poses)', 'tools["certificate"](part(np.arange(m)), poses)'),
    stopped_by="pipeline-outliers",
)
"""Wrong: asks for a certificate of the whole graph, outliers and all."""

wrong_certifies_before_the_polish = change(
    right_indices,
    ('poses = tools["polish"]', 'best = tools["polish"]'),
    ('"poses": poses', '"poses": best'),
    caught_by="pipeline-passed-on",
)
"""Wrong: the certificate is of the poses before the polish, which are not at rest."""

wrong_polish_with_all_that_agreed = change(
    right_indices,
    ('poses = tools["polish"](part(kept), poses)', 'poses = tools["polish"](part(first), poses)'),
    caught_by="pipeline-passed-on",
)
"""Wrong: polishes with closures that the solver has dropped."""

wrong_poses_of_the_solver = change(
    right_indices,
    ('poses = tools["polish"]', 'best = tools["polish"]'),
    ('tools["certificate"](part(kept), poses)', 'tools["certificate"](part(kept), best)'),
    stopped_by="pipeline-passed-on",
)
"""Wrong: returns the poses of the solver in place of the polished ones."""

wrong_order_of_the_edges = change(
    right_indices,
    ('steps[np.argsort(graph["edges"][steps, 0])]', "steps"),
    caught_by="pipeline-order",
)
"""Wrong: takes the steps in the order of the edges."""

wrong_no_closures = change(
    right_indices,
    "loops[members]",
    "np.max(loops) * 0 + loops[members]",
    stopped_by="pipeline-alone",
)
"""Wrong: cannot do without closures: an empty list is no index."""
