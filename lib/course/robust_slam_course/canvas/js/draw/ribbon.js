/** The letters of `ribbon`, one for each of `count` places, "." where nothing was tried; `at` gets `letter`. */
export function painted(ribbon, count, at, letter) {
  const known = typeof ribbon === "string" ? ribbon : "";
  return Array.from({ length: count }, (_, k) => (k === at ? letter : known[k] ?? ".")).join("");
}

/** The letter of a place where what is tried ends well, or is lost. */
export function letterOf(lost) {
  return lost ? "w" : "g";
}

/**
 * The places that a reader has tried, from left to right in the box `{x, y, width, height}` (pixels):
 * green where it went well, orange and twice as tall where not. `faint` is for one that is not held.
 */
export function putRibbon(scene, layer, key, { x, y, width, height }, ribbon, faint = false) {
  const each = width / ribbon.length;
  const style = `stroke-dasharray:none;stroke-linecap:butt;opacity:${faint ? 0.45 : 1}`;
  for (const [letter, look, share] of [[".", "is-grid", 0.25], ["g", "is-inlier", 0.5], ["w", "is-outlier", 1]]) {
    const d = [...ribbon].map((one, k) => (one === letter
      ? `M${(x + (k + 0.5) * each).toFixed(1)} ${y + height}v${(-share * height).toFixed(1)}` : "")).join("");
    scene.put(layer, `${key}-${letter}`, "path", { class: look, d, style, "stroke-width": 0.86 * each });
  }
  scene.path(layer, `${key}-floor`, "is-muted", `M${x} ${y + height}h${width}`, 1);
}
