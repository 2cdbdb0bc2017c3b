/**
 * A legend in one line, from `x` on (pixels), and in more lines where `width` is too small:
 * `entries` is `[[look, text], …]` with the class of each line. Returns its height.
 */
export function putLegend(scene, layer, key, x, y, width, entries) {
  const [sample, gap, letter, row] = [24, 14, 7.2, 20];
  let [left, top] = [x, y];
  entries.forEach(([look, text], k) => {
    const space = sample + 6 + letter * text.length;
    if (left > x && left + space > x + width) [left, top] = [x, top + row];
    scene.put(layer, `${key}-line-${k}`, "path", {
      class: `rs-line ${look}`, d: `M${left} ${top + 8}h${sample}`,
    });
    scene.put(layer, `${key}-text-${k}`, "text", { x: left + sample + 6, y: top + 13 }, text);
    left += space + gap;
  });
  return top + row - y;
}
