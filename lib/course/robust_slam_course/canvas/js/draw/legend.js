import { setAttributes } from "./scene.js";

export const MAP_LEGEND = [["is-ghost", "true path"], ["is-estimate", "map"], ["is-inlier", "inlier"], ["is-outlier", "outlier"]];

/**
 * A legend in one line, from `x` on (pixels), and in more lines where `width` is too small:
 * `entries` is `[[look, text], …]` with the class of each line. Returns its height.
 */
export function putLegend(scene, layer, key, x, y, width, entries) {
  const [sample, gap, row] = [24, 20, 20];
  const words = entries.map(([, text], k) => scene.put(layer, `${key}-text-${k}`, "text", {}, text));
  const lengths = words.map((element) => element.getComputedTextLength());
  let [left, top] = [x, y];
  entries.forEach(([look], k) => {
    const space = sample + 6 + lengths[k];
    if (left > x && left + space > x + width) [left, top] = [x, top + row];
    scene.path(layer, `${key}-line-${k}`, `rs-line ${look}`, `M${left} ${top + 8}h${sample}`);
    setAttributes(words[k], { x: left + sample + 6, y: top + 13 });
    left += space + gap;
  });
  return top + row - y;
}
