/**
 * Poses in the plane: composition, inverse and logarithm.
 *
 * A pose is [x, y, θ] in m, m and rad; a tangent vector is (ρx, ρy, θ) in the same units.
 * Perturbations are on the right, p ∘ Exp(δ). Every function takes arrays of 3 numbers and
 * returns a new one.
 *
 * Source: as `robust_slam.graphs.se2`: Solà, Deray and Atchuthan 2018, the appendix on SE(2).
 */

/** Return the angle in (−π, π] equal to `angle` modulo 2π; one inside is unchanged. */
export function wrapAngle(angle) {
  return angle - 2 * Math.PI * Math.ceil(angle / (2 * Math.PI) - 0.5);
}

/** Return sin(x)/x, which is 1 at 0. */
export function sineRatio(x) {
  return x === 0 ? 1 : Math.sin(x) / x;
}

/** Return (θ/2) cot(θ/2), which is 1 at 0. */
export function halfCotangent(angle) {
  return Math.cos(angle / 2) / sineRatio(angle / 2);
}

/**
 * Return (1 − (θ/2) cot(θ/2))/θ, which is about θ/12.
 *
 * Near 0 the difference suffers from cancellation, so its series is used.
 */
export function logCoefficient(angle) {
  if (Math.abs(angle) >= 0.05) return (1 - halfCotangent(angle)) / angle;
  const square = angle * angle;
  return angle * (1 / 12 + square * (1 / 720 + square / 30240));
}

/** Return a ∘ b: the pose b, given relative to a, in the frame of a. */
export function se2Compose(a, b) {
  const cosine = Math.cos(a[2]);
  const sine = Math.sin(a[2]);
  return [
    a[0] + cosine * b[0] - sine * b[1],
    a[1] + sine * b[0] + cosine * b[1],
    wrapAngle(a[2] + b[2]),
  ];
}

/** Return p⁻¹, for which p ∘ p⁻¹ is [0, 0, 0]. */
export function se2Inverse(p) {
  const cosine = Math.cos(p[2]);
  const sine = Math.sin(p[2]);
  return [-cosine * p[0] - sine * p[1], sine * p[0] - cosine * p[1], wrapAngle(-p[2])];
}

/** Return a⁻¹ ∘ b: b in the frame of a. */
export function se2Between(a, b) {
  const cosine = Math.cos(a[2]);
  const sine = Math.sin(a[2]);
  const x = b[0] - a[0];
  const y = b[1] - a[1];
  return [cosine * x + sine * y, cosine * y - sine * x, wrapAngle(b[2] - a[2])];
}

/** Return the twist with Exp(twist) = p and its angle in (−π, π]. */
export function se2Log(p) {
  const angle = wrapAngle(p[2]);
  const a = halfCotangent(angle);
  const b = -angle / 2;
  return [a * p[0] - b * p[1], b * p[0] + a * p[1], angle];
}

/** Return Ad(p), 9 numbers by rows, for which p ∘ Exp(δ) = Exp(Ad(p) δ) ∘ p. */
export function se2Adjoint(p) {
  const cosine = Math.cos(p[2]);
  const sine = Math.sin(p[2]);
  return [cosine, -sine, p[1], sine, cosine, -p[0], 0, 0, 1];
}

/** Return pose k of `poses` (3n). */
export function poseOf(poses, k) {
  return [poses[3 * k], poses[3 * k + 1], poses[3 * k + 2]];
}
