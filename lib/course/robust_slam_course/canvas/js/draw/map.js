import { putHandle } from "./handle.js";
import { lineBetween, pathThrough } from "./scene.js";

/**
 * Maps between metres and pixels that fit `poses` (x, y, θ one after the other, in m, m, rad)
 * into the box `{x, y, width, height}` (pixels), with one scale for both axes; `room` is what stays free
 * around them, in metres.
 */
export function fitMap(box, poses, margin = 26, room = 0) {
  let [west, east, south, north] = [Infinity, -Infinity, Infinity, -Infinity];
  for (let k = 0; k < poses.length; k += 3) {
    west = Math.min(west, poses[k]);
    east = Math.max(east, poses[k]);
    south = Math.min(south, poses[k + 1]);
    north = Math.max(north, poses[k + 1]);
  }
  const scale = Math.min(
    (box.width - 2 * margin) / Math.max(east - west + 2 * room, 1e-9),
    (box.height - 2 * margin) / Math.max(north - south + 2 * room, 1e-9),
  );
  const [x0, y0] = [box.x + box.width / 2, box.y + box.height / 2];
  const [mx, my] = [(west + east) / 2, (south + north) / 2];
  return {
    scale,
    toX: (x) => x0 + scale * (x - mx),
    toY: (y) => y0 - scale * (y - my),
    fromX: (pixel) => mx + (pixel - x0) / scale,
    fromY: (pixel) => my - (pixel - y0) / scale,
  };
}

const STEP = 0.08; // of the map's size, by which a side of it is moved out

/**
 * As `fitMap` of `truth`, with sides moved out by whole steps until `poses` are in the box, too.
 * The map named `key` stays as long as the hand that took a handle is in the drawing: what it held, and
 * may take again, stays at the hand.
 */
export function fitAround(scene, key, box, truth, poses, margin = 24) {
  const kept = scene.fits.get(key);
  if (scene.held && kept) return kept;
  // Handles stand in the margin, and a line may run into it.
  const slack = (margin - 6) / fitMap(box, truth, margin).scale;
  const corners = [0, 1].flatMap((axis) => {
    const [own, all] = [truth, [...truth, ...poses]].map((list) => list.filter((_, k) => k % 3 === axis));
    const [low, high] = [Math.min(...own), Math.max(...own)];
    const step = STEP * (high - low);
    const out = (far) => step * Math.ceil(Math.max(0, far - slack) / step);
    return [low - out(low - Math.min(...all)), high + out(Math.max(...all) - high)];
  });
  const [west, east, south, north] = corners;
  const fit = fitMap(box, [west, south, 0, east, north, 0], margin);
  scene.fits.set(key, fit);
  return fit;
}

/** Pixels of pose `k`. */
export function posePixels(map, poses, k) {
  return [map.toX(poses[3 * k]), map.toY(poses[3 * k + 1])];
}

/** The drive through `poses` in order, a line with a dot for each pose. */
export function putDrive(scene, layer, key, map, poses, look) {
  const points = Array.from({ length: poses.length / 3 }, (_, k) => posePixels(map, poses, k));
  scene.path(layer, `${key}-line`, `rs-drive ${look}`, pathThrough(points));
  const dots = points.map(([x, y]) => `M${x.toFixed(1)} ${y.toFixed(1)}h0`).join("");
  scene.path(layer, `${key}-dots`, `rs-dots ${look}`, dots);
}

/** An edge between poses `i` and `j`; `width` in pixels, `look` a class of the style sheet. */
export function putEdge(scene, layer, key, map, poses, [i, j], look, width = 2) {
  const ends = lineBetween(posePixels(map, poses, i), posePixels(map, poses, j));
  return scene.put(layer, key, "line", { class: `rs-edge ${look}`, ...ends, "stroke-width": width, "data-part": key });
}

/**
 * The pose nearest to a point in metres; those for which `allowed(k)` is false are left out. Where the
 * drive crosses itself it is the visit nearest in number to `held`, the pose that was there before.
 */
export function nearestPose(poses, x, y, held, allowed = () => true) {
  let [best, least] = [-1, Infinity];
  for (let k = 0; k < poses.length / 3; k += 1) {
    const distance = Math.hypot(poses[3 * k] - x, poses[3 * k + 1] - y) + 1e-4 * Math.abs(k - held);
    if (distance < least && allowed(k)) [best, least] = [k, distance];
  }
  return best;
}

const JOIN_GAP = 2; // poses, from one end of a closure to the other

/**
 * The two ends of each closure in `closures` as handles on `poses`. An end snaps to the
 * nearest pose; arrows move it along the drive. `edit(list)` is told the new closures;
 * Delete removes one where `removable`. `last` is the last pose that may be joined.
 */
export function putClosureHandles(scene, map, poses, closures, edit, {
  noun, removable = true, last = poses.length / 3 - 1,
}) {
  closures.forEach((closure, number) => [0, 1].forEach((end) => {
    const [here, there] = [closure[end], closure[1 - end]];
    const move = (pose) => edit(closures.map((other, k) => {
      if (k !== number || Math.abs(pose - there) < JOIN_GAP) return other;
      return end === 0 ? [pose, there] : [there, pose];
    }));
    const [x, y] = posePixels(map, poses, here);
    putHandle(scene, `closure-${number}-${end}`, {
      x, y, shape: end ? "diamond" : "circle", look: "rs-wrong",
      label: `${noun} ${number + 1}, ${end ? "second" : "first"} end`,
      text: `pose ${here}`, now: here, least: 0, most: last,
      drag: (px, py) => move(nearestPose(
        poses, map.fromX(px), map.fromY(py), here, (k) => k <= last && Math.abs(k - there) >= JOIN_GAP,
      )),
      step: (right, up) => {
        const steps = right || up;
        const to = Math.min(last, Math.max(0, here + steps));
        // Past the other end, on to the first pose on its far side, or where there is none, on this side.
        const [far, near] = [there + Math.sign(steps) * JOIN_GAP, there - Math.sign(steps) * JOIN_GAP];
        move(Math.abs(to - there) >= JOIN_GAP ? to : far >= 0 && far <= last ? far : near);
      },
      remove: removable ? () => edit(closures.filter((_, k) => k !== number)) : undefined,
    });
  }));
}
