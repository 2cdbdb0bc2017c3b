/**
 * Switchable constraints: each untrusted edge has a switch s in [0, 1] on its residual.
 *
 * The objective is Σ χ² over the trusted edges plus Σ s²χ² + λ(1 − s)² over the others, without a
 * ½; the cost of every result is half of it. At fixed poses the optimal switch is s = λ/(λ + χ²),
 * and the weight of the edge is s². Substituted, it leaves the Geman–McClure kernel with c² = λ.
 *
 * Source: as `robust_slam.estimators.switches`: Sünderhauf and Protzel 2012; Agarwal et al. 2013.
 */
import { dampingFactor, retractPoses, stepIsSmall } from "./descent.js";
import { costIncreases } from "./rounding.js";
import { STOP, irls } from "./loop.js";
import {
  assembleEquations,
  blockRowTimes,
  evaluateEdges,
  linearChange,
  linearCostChange,
  lineariseEdges,
  quadraticForm,
  solveEquations,
} from "./normal_equations.js";

/** The damping after the first rejected step, and by default before it. */
const LEAST_DAMPING = 1e-4;

/** Return the optimal switch λ/(λ + χ²); the weight of the edge is its square. */
export function optimalSwitch(chi2, lam) {
  return lam / (lam + chi2);
}

/** Return λχ²/(λ + χ²), the minimum of s²χ² + λ(1 − s)² over s. */
export function switchedCost(chi2, lam) {
  return chi2 * optimalSwitch(chi2, lam);
}

/** Return the switch min(1, 2Φ/(Φ + χ²)) of dynamic covariance scaling. */
export function dcsSwitch(chi2, phi) {
  return Math.min(1, (2 * phi) / (phi + chi2));
}

/** Minimise the switched cost by alternating the solve and the closed-form switches. */
export function switchable(problem, lam, x0 = null, options = {}) {
  return irls(problem, "geman-mcclure", Math.sqrt(lam), x0, options);
}

/** Run dynamic covariance scaling: the loop with the weight s² of `dcsSwitch`. */
export function dynamicCovarianceScaling(problem, phi, x0 = null, options = {}) {
  return irls(problem, "dcs", Math.sqrt(phi), x0, options);
}

/**
 * Minimise the switched cost over poses and switches together, on a pose-graph problem.
 *
 * The poses start at `x0`, or at least squares if it is null, the switches at `s0` (m,), 1 by
 * default. Each step is a Gauss–Newton step on both, with adaptive damping of the poses. The
 * weights of a step are s². The result is that of `reweight`.
 */
export function jointSwitchable(problem, lam, x0 = null, s0 = null, options = {}) {
  const { tol = 1e-9, maxIterations = 500, keepHistory = true } = options;
  let damping = options.damping ?? LEAST_DAMPING;
  const model = switchedModel(problem, lam);
  const switches = Float64Array.from({ length: problem.count }, (_, k) =>
    problem.trusted[k] || s0 === null ? 1 : s0[k],
  );
  let current = model.at(x0 ?? problem.initial(), switches);
  const history = [recordOf(current)];
  let growth = 2;
  for (let iteration = 0; iteration < maxIterations; iteration++) {
    const { step, change, predicted } = model.step(current, damping);
    if (step === null) throw new Error("the edges in use do not determine the poses");
    const moved = current.switches.map((s, k) => Math.min(Math.max(s + change[k], 0), 1));
    const trial = model.at(retractPoses(current.poses, step), moved);
    if (costIncreases(trial.cost, current.cost)) {
      damping = Math.max(LEAST_DAMPING, growth * damping);
      growth *= 2;
      continue;
    }
    if (keepHistory) history.push(recordOf(trial));
    else history[0] = recordOf(trial);
    const small =
      stepIsSmall(step, current.poses, tol) && change.every((one) => Math.abs(one) <= tol);
    if (small && damping === 0) return endingOf(history, STOP.converged);
    // A damped step can be small anywhere, an undamped one only near a minimum.
    const gain = (current.cost - trial.cost) / predicted;
    damping = small ? 0 : damping * dampingFactor(gain);
    current = trial;
    growth = 2;
  }
  return endingOf(history, STOP.iterationLimit);
}

function recordOf({ poses, switches, cost }) {
  return { x: poses, weights: switches.map((s) => s * s), cost, mu: null };
}

function endingOf(history, stop) {
  const { x, weights, cost } = history[history.length - 1];
  return { x, weights, cost, stop, history };
}

/**
 * Return the joint problem ½ Σ s²χ² + λ(1 − s)², in which trusted edges keep s = 1.
 *
 * A switch belongs to one edge, so a Schur complement eliminates it exactly, and back
 * substitution recovers it. Per edge, with v = Ωr, h = χ² + λ and g = sχ² − λ(1 − s), the
 * derivative of the cost by s, the complement is
 *   A = s²(Ω − v vᵀ/h),   p = (s² − s g/h) v,   δs = −(g + s vᵀJδ)/h.
 */
function switchedModel(problem, lam) {
  const { graph, equations, trusted } = problem;
  const { m, information } = graph;
  const ones = new Float64Array(m).fill(1);
  const reduced = new Float64Array(9 * m);
  const pulls = new Float64Array(3 * m);
  const inverse = new Float64Array(m);
  const slope = new Float64Array(m);

  function at(poses, switches) {
    evaluateEdges(equations, poses, ones);
    let sum = 0;
    for (let k = 0; k < m; k++) {
      const chi2 = Math.max(0, quadraticForm(information, equations.residuals, k));
      sum += switches[k] ** 2 * chi2 + lam * (1 - switches[k]) ** 2;
    }
    return { poses, switches, cost: 0.5 * sum };
  }

  function eliminate(s, k) {
    const v = [0, 1, 2].map((row) =>
      blockRowTimes(information, 9 * k, row, equations.residuals, 3 * k),
    );
    const chi2 = quadraticForm(information, equations.residuals, k);
    // A trusted edge has a switch of infinite stiffness: 1/h = 0 leaves A = Ω and p = Ωr.
    inverse[k] = trusted[k] ? 0 : 1 / (chi2 + lam);
    slope[k] = s * chi2 - lam * (1 - s);
    for (let row = 0; row < 3; row++) {
      pulls[3 * k + row] = (s * s - s * slope[k] * inverse[k]) * v[row];
      for (let column = 0; column < 3; column++) {
        const entry = 9 * k + 3 * row + column;
        reduced[entry] = s * s * (information[entry] - inverse[k] * v[row] * v[column]);
      }
    }
    return v;
  }

  function step(current, damping) {
    const s = current.switches;
    evaluateEdges(equations, current.poses, ones);
    lineariseEdges(equations);
    const forces = Array.from(s, eliminate);
    assembleEquations(equations, reduced, ones, pulls);
    const moved = solveEquations(equations, damping);
    if (moved === null) return { step: null };
    const along = linearChange(equations, moved);
    const change = new Float64Array(m);
    let predicted = -linearCostChange(equations, reduced, ones, pulls);
    for (let k = 0; k < m; k++) {
      const [x, y, z] = forces[k];
      const pulled = x * along[3 * k] + y * along[3 * k + 1] + z * along[3 * k + 2];
      change[k] = -inverse[k] * (slope[k] + s[k] * pulled);
      predicted += 0.5 * inverse[k] * slope[k] ** 2;
    }
    return { step: moved, change, predicted: Math.max(predicted, Number.MIN_VALUE) };
  }

  return { at, step };
}
