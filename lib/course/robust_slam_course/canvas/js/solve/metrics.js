/**
 * Errors of maps.
 *
 * Maps are flat arrays of poses (3n).
 *
 * Source: as `robust_slam.graphs.metrics`: Umeyama 1991; Sturm et al. 2012.
 */
import { poseOf, se2Compose } from "./se2.js";

/**
 * Return the poses `estimate` moved by the rigid motion, without scale, that minimises the sum of
 * squared distances of their positions to those of `truth` (m).
 */
export function alignPoses(estimate, truth) {
  const from = meanPosition(estimate);
  const to = meanPosition(truth);
  let cosine = 0;
  let sine = 0;
  for (let at = 0; at < truth.length; at += 3) {
    const [x, y] = [estimate[at] - from[0], estimate[at + 1] - from[1]];
    const [goalX, goalY] = [truth[at] - to[0], truth[at + 1] - to[1]];
    cosine += x * goalX + y * goalY;
    sine += x * goalY - y * goalX;
  }
  const angle = Math.atan2(sine, cosine);
  const turned = se2Compose([0, 0, angle], [from[0], from[1], 0]);
  const motion = [to[0] - turned[0], to[1] - turned[1], angle];
  const aligned = new Float64Array(estimate.length);
  for (let at = 0; at < estimate.length; at += 3) {
    aligned.set(se2Compose(motion, poseOf(estimate, at / 3)), at);
  }
  return aligned;
}

/** Return the absolute trajectory error (m): the RMSE of positions after `alignPoses`. */
export function ate(estimate, truth) {
  const aligned = alignPoses(estimate, truth);
  let sum = 0;
  for (let at = 0; at < truth.length; at += 3) {
    sum += (aligned[at] - truth[at]) ** 2 + (aligned[at + 1] - truth[at + 1]) ** 2;
  }
  return Math.sqrt(sum / (truth.length / 3));
}

function meanPosition(poses) {
  const sum = [0, 0];
  for (let at = 0; at < poses.length; at += 3) {
    sum[0] += poses[at];
    sum[1] += poses[at + 1];
  }
  return sum.map((total) => total / (poses.length / 3));
}
