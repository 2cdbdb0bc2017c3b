/**
 * A solver on a town with agreeing outliers: who fools it with the fewest?
 *
 * Source: as `rules.py`.
 */
import { agreeingClosures } from "../../canvas/js/solve/aliasing.js";
import { firstClique, pcm } from "../../canvas/js/solve/consistency.js";
import { gnc } from "../../canvas/js/solve/graduation.js";
import { irls } from "../../canvas/js/solve/loop.js";
import { ate } from "../../canvas/js/solve/metrics.js";
import { CHI_99_SE2, graphWithWrong, leastSquares, poseGraphProblem } from "../../canvas/js/solve/pose_graph.js";

const ATTACKED = {
  squares: (graph) => {
    const { poses } = leastSquares(poseGraphProblem(graph));
    return { x: poses, weights: new Float64Array(graph.m).fill(1) };
  },
  gm: (graph) => {
    const problem = poseGraphProblem(graph);
    return irls(problem, "geman-mcclure", CHI_99_SE2, problem.guess, { tol: 1e-6 });
  },
  gnc: (graph) => {
    const problem = poseGraphProblem(graph);
    return gnc(problem, CHI_99_SE2, "tls", problem.guess, { tol: 1e-6 });
  },
};

/**
 * Return { graph, poses, weights, bent }: all edges, the map (3n), the weight of each edge, those of the attack
 * last, and how far the map is from the least-squares map without outliers (m). `data` is as for
 * `graphWithWrong`, `ends` are the poses of the first closure, and `offset` its two numbers (m).
 */
export function attackedMap(data, { solver, ends, offset, count }) {
  const wrong = agreeingClosures(data.truth, ends, count, [...offset, 0]);
  const whole = graphWithWrong(data, wrong);
  const taken = solver === "pcm" ? keptByPcm(whole) : [...Array(whole.m).keys()];
  const { x, weights } = ATTACKED[solver === "pcm" ? "gnc" : solver](graphWithWrong(data, wrong, taken));
  const all = new Float64Array(whole.m);
  taken.forEach((edge, k) => { all[edge] = weights[k]; });
  const { poses } = leastSquares(poseGraphProblem(graphWithWrong(data, { edges: [] })));
  return { graph: whole, poses: x, weights: all, bent: ate(x, poses) };
}

/** The numbers of the edges that PCM keeps; of largest sets the one that comes first. */
function keptByPcm(graph) {
  const { closures, clique, adjacency } = pcm(graph, CHI_99_SE2);
  const kept = firstClique(adjacency, closures.length, clique.length).map((place) => closures[place]);
  return [...Array(graph.m).keys()].filter((edge) => graph.isOdometry[edge] || kept.includes(edge));
}
