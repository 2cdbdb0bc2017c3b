/**
 * The Riemannian staircase on headings, a way out of local minima.
 *
 * Stationary rotations without a certificate come with a direction along which the cost falls
 * once the rotations have one more row. The staircase adds the row, steps along the direction and
 * descends, until the certificate holds. Each descent is Newton's method in a trust region with
 * truncated conjugate gradients. Heading 0 is fixed.
 *
 * Source: as `robust_slam.certificates.staircase` and `newton`: Boumal, Voroninski and Bandeira
 * 2016; Absil, Baker and Gallivan 2007, Algorithms 1 and 2; Steihaug 1983.
 */
import {
  certify, dotProduct, headingsStationarity, lessMultipliers, multipliersOf, quadraticCost,
  rowsTimes, symmetricProducts, traceOf,
} from "./certificate.js";
import { symmetricEigen } from "./eigen.js";
import { costIncreases } from "./rounding.js";
import { denseFactor, skylineSolve } from "./skyline.js";

const CLIMB_HALVINGS = 40;
const INNER_LIMIT = 300;
const FORCING = 0.1;
const FIRST_RADIUS = 4;

/** The rounding error of a difference of costs, relative to the cost and to the sizes in Q. */
const COST_NOISE = 1e-13;
const MATRIX_NOISE = 1e-15;

/** Below this stationarity a step that does not halve it has reached rounding level. */
const FLAT = 1e-9;

/** Shares θ of the multipliers in the preconditioner Q − θ Λ, the best first. */
const LEVELS = [1, 0.9, 0.5, 0];

/**
 * Return R (r + 1, 2n) with one more row, of lower cost than R (r, 2n).
 *
 * The new row is a multiple of `direction` (2n,), for instance that of `certify`, halved until
 * the cost falls.
 */
function climb(Q, R, r, direction) {
  const here = quadraticCost(Q, R, r);
  const lengths = direction.map((entry, c) => Math.hypot(entry, direction[c ^ 1]));
  const longest = Math.max(...lengths);
  for (let halvings = 0; halvings < CLIMB_HALVINGS; halvings++) {
    const scale = 0.5 ** halvings / longest;
    const moved = nearestStiefel([...R, ...direction.map((entry) => scale * entry)], r + 1);
    if (quadraticCost(Q, moved, r + 1) < here) return moved;
  }
  return Float64Array.from([...R, ...direction.map(() => 0)]);
}

/**
 * Return the descent of tr(R Q Rᵀ) from R (r, 2n) to a minimum near it.
 *
 * Each of its points is { R, cost, stationarity }, the start first, for a picture to play. The
 * cost never increases, and heading 0 stays.
 */
export function descend(Q, R, r, { tol = 1e-13, maxIterations = 200 } = {}) {
  const history = [pointAt(Q, R, r)];
  const state = { radius: null, level: 0 };
  for (let iteration = 0; iteration < maxIterations; iteration++) {
    const point = history.at(-1);
    if (point.stationarity <= tol) break;
    const { step, trial } = advance(Q, r, point, state);
    if (trial === null) break;
    const flat = point.stationarity < FLAT && trial.stationarity > 0.5 * point.stationarity;
    // Near a saddle such a step is rounding along a direction of negative curvature.
    if (!(flat && trial.stationarity > point.stationarity)) history.push(trial);
    if (!step.atEdge && flat) break;
  }
  return history;
}

/**
 * Return the levels of the staircase from R (2, 2n), each { r, proof, history }.
 *
 * `proof` is the certificate at the end of a level, `history` the descent that led there. It ends
 * at the first level whose certificate has no negative eigenvalue, or after `maxClimbs`.
 */
export function staircase(Q, R, maxClimbs = 5) {
  const levels = [{ r: 2, proof: certify(Q, R, 2), history: [pointAt(Q, R, 2)] }];
  for (let r = 2; r < 2 + maxClimbs; r++) {
    const { proof, history } = levels.at(-1);
    if (proof.direction === null) break;
    const direction = r === 2 ? steadyAtFirst(proof.direction) : proof.direction;
    const higher = climb(Q, history.at(-1).R, r, direction);
    const descent = descend(Q, higher, r + 1);
    levels.push({ r: r + 1, proof: certify(Q, descent.at(-1).R, r + 1), history: descent });
  }
  return levels;
}

/**
 * Return an eigenvector at rank 2 with each block turned, which leaves it one, so that the arrow
 * of heading 0 does not rise: of the many ways out a picture shows one.
 */
function steadyAtFirst(vector) {
  const size = Math.hypot(vector[0], vector[1]);
  if (size < 1e-9) return vector;
  const [cosine, sine] = [-vector[1] / size, -vector[0] / size];
  return vector.map((entry, c) => cosine * entry + (c % 2 ? sine : -sine) * vector[c ^ 1]);
}

/**
 * Return headings (n,) in rad near R (r, 2n) of any rank: the projection on its two dominant
 * directions, each block replaced by the nearest rotation, turned so that heading 0 is `first`.
 */
export function roundedHeadings(R, r, first = 0) {
  const width = R.length / r;
  const rows = Array.from({ length: r }, (_, row) => R.subarray(row * width, (row + 1) * width));
  const gram = rows.flatMap((one) => rows.map((other) => dotProduct(one, other)));
  const { vectors } = symmetricEigen(Float64Array.from(gram), r);
  const [high, low] = [r - 1, r - 2].map((k) => (
    combined(rows, vectors.subarray(k * r, (k + 1) * r))));
  let mirrored = 0;
  for (let c = 0; c < width; c += 2) {
    mirrored += high[c] * low[c + 1] < high[c + 1] * low[c] ? 2 : 0;
  }
  const sign = mirrored > width / 2 ? -1 : 1;
  const angles = Float64Array.from({ length: width / 2 }, (_, i) => {
    const c = 2 * i;
    return Math.atan2(sign * low[c] - high[c + 1], high[c] + sign * low[c + 1]);
  });
  return angles.map((angle) => angle - angles[0] + first);
}

function pointAt(Q, R, r) {
  return { R, cost: quadraticCost(Q, R, r), stationarity: headingsStationarity(Q, R, r) };
}

/**
 * Return a step and its point, of no higher cost; the point is null if a step gains rounding
 * alone. The radius shrinks until the quadratic model predicts the cost well enough.
 */
function advance(Q, r, point, state) {
  const model = quadraticModel(Q, r, point.R, state);
  if (state.radius === null) {
    const size = dotProduct(model.gradient, model.inverse(model.gradient));
    state.radius = FIRST_RADIUS * Math.sqrt(size);
  }
  const negligible = MATRIX_NOISE * traceOf(Q);
  const noise = COST_NOISE * point.cost + negligible;
  for (;;) {
    const step = truncatedStep(model, point.stationarity, state.radius);
    const moved = combined([...model.basis, point.R], [...step.coordinates, 1]);
    const trial = pointAt(Q, nearestStiefel(moved, r), r);
    const ratio = (point.cost - trial.cost + noise) / (step.decrease + noise);
    state.radius = nextRadius(state.radius, step, ratio);
    if (ratio > 0.05 && !costIncreases(trial.cost, point.cost, negligible)) return { step, trial };
    if (step.decrease <= noise) return { step, trial: null };
  }
}

function nextRadius(radius, step, ratio) {
  if (!(ratio >= 0.25)) return 0.25 * step.length;
  if (!step.atEdge || ratio < 0.75) return radius;
  return ratio < 0.9 ? 2 * radius : 4 * radius;
}

/**
 * Return the model at R in coordinates of the tangent `basis`: half the gradient, half the Hessian
 * as a map, and the inverse of Q − θ Λ, with the largest θ for which it is positive definite.
 */
function quadraticModel(Q, r, R, state) {
  const multipliers = multipliersOf(Q, R, r);
  const basis = tangentBasis(R, r);
  const restricted = (theta) => {
    const matrix = lessMultipliers(Q, multipliers, theta);
    const images = basis.map((vector) => rowsTimes(vector, r, matrix));
    return basis.map((one) => Float64Array.from(images, (image) => dotProduct(one, image)));
  };
  const [slope, curvature] = [rowsTimes(R, r, Q), restricted(1)];
  state.level = Math.max(0, state.level - 1);
  // On a connected graph Q itself, the last level, is positive definite where heading 0 is fixed.
  for (; state.level < LEVELS.length; state.level++) {
    const matrix = Float64Array.from(restricted(LEVELS[state.level]).flatMap((row) => [...row]));
    const factor = denseFactor(matrix, basis.length);
    if (factor === null) continue;
    return {
      basis,
      gradient: Float64Array.from(basis, (vector) => dotProduct(vector, slope)),
      hessian: (vector) => Float64Array.from(curvature, (row) => dotProduct(row, vector)),
      inverse(vector) {
        const solved = vector.slice();
        skylineSolve(factor.pattern, factor.values, solved);
        return solved;
      },
    };
  }
  throw new Error("the measurements do not determine the headings");
}

/** Return a step of truncated conjugate gradients in the region (Steihaug 1983). */
function truncatedStep({ gradient, hessian, inverse }, stationarity, radius) {
  const coordinates = new Float64Array(gradient.length);
  const change = new Float64Array(gradient.length);
  const residual = gradient.slice();
  let scaled = inverse(residual);
  let size = dotProduct(residual, scaled);
  const finished = (length, atEdge) => {
    const decrease = -(2 * dotProduct(gradient, coordinates) + dotProduct(change, coordinates));
    return { coordinates, decrease, length, atEdge };
  };
  if (size === 0) return finished(0, false);
  const goal = size * Math.min(FORCING, Math.sqrt(stationarity)) ** 2;
  let direction = scaled.map((entry) => -entry);
  // In the norm of the preconditioner: of the step, of the direction, and their product.
  let [square, across, along] = [0, 0, size];
  for (let iteration = 0; iteration < INNER_LIMIT; iteration++) {
    const curved = hessian(direction);
    const curvature = dotProduct(direction, curved);
    let length = curvature > 0 ? size / curvature : Infinity;
    const longer = square + 2 * length * across + length * length * along;
    const atEdge = !(longer < radius * radius);
    if (atEdge) {
      const room = across * across + along * (radius * radius - square);
      length = (Math.sqrt(Math.max(room, 0)) - across) / along;
    }
    addMultiple(coordinates, length, direction);
    addMultiple(change, length, curved);
    if (atEdge) return finished(radius, true);
    addMultiple(residual, length, curved);
    scaled = inverse(residual);
    const last = size;
    [square, size] = [longer, dotProduct(residual, scaled)];
    if (size <= goal) break;
    direction = direction.map((entry, k) => (size / last) * entry - scaled[k]);
    across = (size / last) * (across + length * along);
    along = size + (size / last) ** 2 * along;
  }
  return finished(Math.sqrt(square), false);
}

function addMultiple(total, share, vector) {
  for (let k = 0; k < total.length; k++) total[k] += share * vector[k];
}

/** Return Σ share · vector. */
function combined(vectors, shares) {
  const total = new Float64Array(vectors[0].length);
  vectors.forEach((vector, k) => addMultiple(total, shares[k], vector));
  return total;
}

/**
 * Return the tangent basis of the headings but the first, vectors like R (r, 2n): R_i times a
 * quarter turn, and each direction orthogonal to R_i in either column.
 */
function tangentBasis(R, r) {
  const width = R.length / r;
  const basis = [];
  for (let i = 1; i < width / 2; i++) {
    const put = (...columns) => {
      const vector = new Float64Array(R.length);
      columns.forEach((column, c) => column.forEach((entry, row) => {
        vector[row * width + 2 * i + c] = entry;
      }));
      basis.push(vector);
    };
    const columns = [0, 1].map((c) => (
      Float64Array.from({ length: r }, (_, row) => R[row * width + 2 * i + c])));
    put(columns[1].map((entry) => -entry), columns[0]);
    for (const beyond of complement(columns, r)) {
      put(beyond);
      put([], beyond);
    }
  }
  return basis;
}

/** Return orthonormal vectors (r − 2) orthogonal to two orthonormal columns (r,). */
function complement(columns, r) {
  const found = [...columns];
  for (let axis = 0; axis < r && found.length < r; axis++) {
    const unit = Float64Array.from({ length: r }, (_, k) => (k === axis ? 1 : 0));
    // Twice is enough for orthogonality to rounding (Kahan).
    for (const known of [...found, ...found]) addMultiple(unit, -dotProduct(known, unit), known);
    const length = Math.sqrt(dotProduct(unit, unit));
    if (length > 0.5 / Math.sqrt(r)) found.push(unit.map((entry) => entry / length));
  }
  return found.slice(2);
}

/** Return for each block Y (r, 2) the nearest one with orthonormal columns, Y (YᵀY)^(−½). */
function nearestStiefel(blocks, r) {
  const R = Float64Array.from(blocks);
  const width = R.length / r;
  const gram = symmetricProducts(R, R, r);
  for (let c = 0; c < width; c += 2) {
    const [a, b, , d] = gram.subarray(2 * c, 2 * c + 4);
    // For 2 × 2 matrices A^(−½) = ((tr A + s) I − A)/(s t), s = √det A, t = √(tr A + 2s).
    const s = Math.sqrt(a * d - b * b);
    const t = Math.sqrt(a + d + 2 * s);
    for (let row = 0; row < R.length; row += width) {
      const [x, y] = [R[row + c], R[row + c + 1]];
      R[row + c] = (x * (d + s) - y * b) / (s * t);
      R[row + c + 1] = (y * (a + s) - x * b) / (s * t);
    }
  }
  return R;
}
