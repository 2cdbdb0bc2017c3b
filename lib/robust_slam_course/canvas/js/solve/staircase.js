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
  certify,
  dotProduct,
  headingsStationarity,
  multipliersOf,
  quadraticCost,
  rowsTimes,
  symmetricProducts,
} from "./certificate.js";
import { symmetricEigen } from "./eigen.js";
import { costIncreases } from "./rounding.js";
import { skylineFactor, skylinePattern, skylineSolve } from "./skyline.js";

/** Why a descent stopped, in the words of the library. */
export const DESCENT_STOP = {
  stationary: "stationary",
  rounding: "rounding",
  iterationLimit: "iteration limit",
};

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
export function climb(Q, R, r, direction) {
  const here = quadraticCost(Q, R, r);
  const width = direction.length;
  let longest = 0;
  for (let c = 0; c < width; c += 2) {
    longest = Math.max(longest, Math.hypot(direction[c], direction[c + 1]));
  }
  const level = new Float64Array((r + 1) * width);
  level.set(R);
  for (let halvings = 0; halvings < CLIMB_HALVINGS; halvings++) {
    const moved = level.slice();
    const scale = 0.5 ** halvings / longest;
    for (let c = 0; c < width; c++) moved[r * width + c] = scale * direction[c];
    nearestStiefel(moved, r + 1);
    if (quadraticCost(Q, moved, r + 1) < here) return moved;
  }
  return level;
}

/**
 * Return a minimum of tr(R Q Rᵀ) near R (r, 2n), as { R, cost, stationarity, stop, history }.
 *
 * Each point of the history is { R, cost, stationarity }, the start first, for a picture to play.
 * The cost never increases, and heading 0 stays.
 */
export function descend(Q, R, r, { tol = 1e-13, maxIterations = 200 } = {}) {
  const history = [pointAt(Q, R, r)];
  const state = { radius: null, level: 0 };
  const ending = (stop) => ({ ...history[history.length - 1], stop, history });
  for (let iteration = 0; iteration < maxIterations; iteration++) {
    const point = history[history.length - 1];
    if (point.stationarity <= tol) return ending(DESCENT_STOP.stationary);
    const { step, trial } = advance(Q, r, point, state);
    if (trial === null) return ending(DESCENT_STOP.rounding);
    const flat = point.stationarity < FLAT && trial.stationarity > 0.5 * point.stationarity;
    // Near a saddle such a step is rounding along a direction of negative curvature.
    if (!(flat && trial.stationarity > point.stationarity)) history.push(trial);
    if (!step.atEdge && flat) return ending(DESCENT_STOP.rounding);
  }
  return ending(DESCENT_STOP.iterationLimit);
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
    const { proof, history } = levels[levels.length - 1];
    if (proof.direction === null) break;
    const higher = climb(Q, history[history.length - 1].R, r, proof.direction);
    const descent = descend(Q, higher, r + 1);
    levels.push({ r: r + 1, proof: certify(Q, descent.R, r + 1), history: descent.history });
  }
  return levels;
}

/**
 * Return headings (n,) in rad near R (r, 2n) of any rank: the projection on its two dominant
 * directions, each block replaced by the nearest rotation, turned so that heading 0 is `first`.
 */
export function roundedHeadings(R, r, first = 0) {
  const width = R.length / r;
  const gram = new Float64Array(r * r);
  for (let a = 0; a < r; a++) {
    for (let b = 0; b < r; b++) {
      const [one, other] = [a, b].map((row) => R.subarray(row * width, (row + 1) * width));
      gram[a * r + b] = dotProduct(one, other);
    }
  }
  const { vectors } = symmetricEigen(gram, r);
  const [high, low] = [r - 1, r - 2].map((k) => {
    const row = new Float64Array(width);
    for (let a = 0; a < r; a++) {
      addMultiple(row, vectors[k * r + a], R.subarray(a * width, (a + 1) * width));
    }
    return row;
  });
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
    const trial = pointAt(Q, retractedRows(point.R, step.vectors, r), r);
    const ratio = (point.cost - trial.cost + noise) / (step.decrease + noise);
    state.radius = nextRadius(state.radius, step, ratio);
    if (ratio > 0.05 && !costIncreases(trial.cost, point.cost, negligible)) return { step, trial };
    if (step.decrease <= noise) return { step, trial: null };
  }
}

function traceOf(Q) {
  const size = Math.round(Math.sqrt(Q.length));
  let sum = 0;
  for (let c = 0; c < size; c++) sum += Q[c * size + c];
  return sum;
}

function nextRadius(radius, step, ratio) {
  if (!(ratio >= 0.25)) return 0.25 * step.length;
  if (!step.atEdge || ratio < 0.75) return radius;
  return ratio < 0.9 ? 2 * radius : 4 * radius;
}

/**
 * Return the model at R: half the gradient, half the Hessian as a map of tangent vectors, and the
 * inverse of Q − θ Λ on the tangent space, with the largest θ for which it is positive definite.
 */
function quadraticModel(Q, r, R, state) {
  const multipliers = multipliersOf(Q, R, r);
  const hessian = (vectors) => {
    const product = rowsTimes(vectors, r, Q);
    subtractMultiples(product, vectors, multipliers, r);
    return tangentPart(R, product, r);
  };
  const basis = tangentBasis(R, r);
  state.level = Math.max(0, state.level - 1);
  for (; ; state.level++) {
    const inverse = restrictedInverse(Q, multipliers, LEVELS[state.level], basis, r);
    if (inverse === null && state.level < LEVELS.length - 1) continue;
    if (inverse === null) throw new Error("the measurements do not determine the headings");
    return { gradient: tangentPart(R, rowsTimes(R, r, Q), r), hessian, inverse };
  }
}

/** Return a step of truncated conjugate gradients in the region (Steihaug 1983). */
function truncatedStep({ gradient, hessian, inverse }, stationarity, radius) {
  const vectors = new Float64Array(gradient.length);
  const change = new Float64Array(gradient.length);
  const residual = gradient.slice();
  let scaled = inverse(residual);
  let size = dotProduct(residual, scaled);
  const finished = (length, atEdge) => {
    const decrease = -(2 * dotProduct(gradient, vectors) + dotProduct(change, vectors));
    return { vectors, decrease, length, atEdge };
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
    addMultiple(vectors, length, direction);
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

/** Take V_i Λ_i off each block of `product` (r, 2n). */
function subtractMultiples(product, vectors, multipliers, r) {
  const width = product.length / r;
  for (let row = 0; row < product.length; row += width) {
    for (let c = 0; c < width; c += 2) {
      const [a, b] = [vectors[row + c], vectors[row + c + 1]];
      product[row + c] -= a * multipliers[2 * c] + b * multipliers[2 * c + 2];
      product[row + c + 1] -= a * multipliers[2 * c + 1] + b * multipliers[2 * c + 3];
    }
  }
}

/** Return the tangent vectors at R nearest to V: V_i − R_i sym(R_iᵀV_i), and 0 at heading 0. */
function tangentPart(R, V, r) {
  const width = R.length / r;
  const part = V.slice();
  subtractMultiples(part, R, symmetricProducts(R, V, r), r);
  for (let row = 0; row < part.length; row += width) part[row] = part[row + 1] = 0;
  return part;
}

/**
 * Return the tangent basis of each heading but the first, as [i, block (r, 2)]: R_i times a
 * quarter turn, and each direction orthogonal to R_i in either column.
 */
function tangentBasis(R, r) {
  const width = R.length / r;
  const basis = [];
  for (let i = 1; i < width / 2; i++) {
    const columns = [0, 1].map((column) =>
      Float64Array.from({ length: r }, (_, row) => R[row * width + 2 * i + column]),
    );
    basis.push([i, blockOf(columns[1].map((entry) => -entry), columns[0])]);
    const zero = new Float64Array(r);
    for (const beyond of complement(columns, r)) {
      basis.push([i, blockOf(beyond, zero)], [i, blockOf(zero, beyond)]);
    }
  }
  return basis;
}

function blockOf(first, second) {
  return Float64Array.from({ length: 2 * first.length }, (_, k) =>
    k % 2 === 0 ? first[k / 2] : second[(k - 1) / 2],
  );
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

/** Return the inverse of Q − θ Λ on the span of `basis`, null if it is not positive definite. */
function restrictedInverse(Q, multipliers, theta, basis, r) {
  const width = multipliers.length / 2;
  const pattern = skylinePattern(new Int32Array(basis.length));
  const values = new Float64Array(pattern.length);
  basis.forEach(([i, one], row) => {
    for (let column = 0; column <= row; column++) {
      const [j, other] = basis[column];
      const begin = 2 * i * width + 2 * j;
      const block = [Q[begin], Q[begin + 1], Q[begin + width], Q[begin + width + 1]];
      if (i === j) for (let k = 0; k < 4; k++) block[k] -= theta * multipliers[4 * i + k];
      let sum = 0;
      for (let k = 0; k < 2 * r; k += 2) {
        sum += one[k] * (block[0] * other[k] + block[1] * other[k + 1]);
        sum += one[k + 1] * (block[2] * other[k] + block[3] * other[k + 1]);
      }
      values[pattern.start[row] + column] = sum;
    }
  });
  if (!skylineFactor(pattern, values)) return null;
  return (vectors) => {
    const coordinates = Float64Array.from(basis, ([i, block]) => overBlock(vectors, i, block, r));
    skylineSolve(pattern, values, coordinates);
    const solved = new Float64Array(vectors.length);
    basis.forEach(([i, block], k) => {
      for (let row = 0; row < r; row++) {
        solved[row * width + 2 * i] += coordinates[k] * block[2 * row];
        solved[row * width + 2 * i + 1] += coordinates[k] * block[2 * row + 1];
      }
    });
    return solved;
  };
}

function overBlock(vectors, i, block, r) {
  const width = vectors.length / r;
  let sum = 0;
  for (let row = 0; row < r; row++) {
    const at = row * width + 2 * i;
    sum += vectors[at] * block[2 * row] + vectors[at + 1] * block[2 * row + 1];
  }
  return sum;
}

/** Return R moved by tangent vectors and retracted, with heading 0 unchanged to the last bit. */
function retractedRows(R, vectors, r) {
  const width = R.length / r;
  const moved = R.map((entry, k) => entry + vectors[k]);
  nearestStiefel(moved, r);
  for (let row = 0; row < R.length; row += width) {
    moved[row] = R[row];
    moved[row + 1] = R[row + 1];
  }
  return moved;
}

/** Replace each block Y (r, 2) by the nearest one with orthonormal columns, Y (YᵀY)^(−½). */
function nearestStiefel(R, r) {
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
}
