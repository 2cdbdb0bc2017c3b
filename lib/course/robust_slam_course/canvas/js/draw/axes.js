import { numberText } from "./number.js";
import { pathThrough, setAttributes } from "./scene.js";

/** About `count` round numbers that cover `[low, high]`. */
export function roundTicks(low, high, count = 5) {
  const rough = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) {
    ticks.push(Number((k * step).toPrecision(12)));
  }
  return ticks;
}

/**
 * Two axes with ticks inside the box `{x, y, width, height}` (pixels); `across` and `up` are
 * `{domain: [low, high], label, ticks?, text?}`, `text` from a tick to words; without a label "" leaves
 * less room than null, which is for ticks that the caller puts. Returns the maps between data and pixels.
 */
export function putAxes(scene, layer, key, box, across, up) {
  const [left, bottom, top, right] = [up.label === "" ? 34 : 50, across.label ? 42 : 22, 8, 8];
  const inner = {
    x: box.x + left, y: box.y + top,
    width: box.width - left - right, height: box.height - top - bottom,
  };
  const spanX = across.domain[1] - across.domain[0];
  const spanY = up.domain[1] - up.domain[0];
  const maps = {
    inner,
    toX: (value) => inner.x + ((value - across.domain[0]) / spanX) * inner.width,
    toY: (value) => inner.y + inner.height - ((value - up.domain[0]) / spanY) * inner.height,
    fromX: (pixel) => across.domain[0] + ((pixel - inner.x) / inner.width) * spanX,
    fromY: (pixel) => up.domain[0] + ((inner.y + inner.height - pixel) / inner.height) * spanY,
  };
  const floor = inner.y + inner.height;
  for (const value of across.ticks ?? roundTicks(...across.domain, inner.width / 80)) {
    const x = maps.toX(value);
    scene.path(layer, `${key}-x-${value}`, "rs-grid", `M${x} ${inner.y}V${floor}`);
    scene.text(layer, `${key}-xt-${value}`, x, floor + 17, (across.text ?? numberText)(value), "rs-tick", "middle");
  }
  for (const value of up.ticks ?? roundTicks(...up.domain, inner.height / 45)) {
    const y = maps.toY(value);
    scene.path(layer, `${key}-y-${value}`, "rs-grid", `M${inner.x} ${y}h${inner.width}`);
    scene.text(layer, `${key}-yt-${value}`, inner.x - 6, y + 5, (up.text ?? numberText)(value), "rs-tick", "end");
  }
  if (across.label) {
    scene.text(layer, `${key}-xl`, inner.x + inner.width / 2, floor + 36, across.label, "", "middle");
  }
  if (up.label) {
    const [x, y] = [box.x + 13, inner.y + inner.height / 2];
    setAttributes(scene.text(layer, `${key}-yl`, x, y, up.label, "", "middle"), { transform: `rotate(-90 ${x} ${y})` });
  }
  return maps;
}

/** A curve y = f(x) over the axes' box, cut off above and below it. */
export function putCurve(scene, layer, key, maps, domain, f, attributes, samples = 200) {
  const { inner } = maps;
  const clamp = (y) => Math.min(inner.y + inner.height + 2000, Math.max(inner.y - 2000, y));
  const points = Array.from({ length: samples + 1 }, (_, k) => {
    const x = domain[0] + ((domain[1] - domain[0]) * k) / samples;
    return [maps.toX(x), clamp(maps.toY(f(x)))];
  });
  return putPath(scene, layer, key, maps, points, attributes);
}

/** A path through points in pixels, clipped to the axes' box. */
export function putPath(scene, layer, key, maps, points, attributes) {
  const { x, y, width, height } = maps.inner;
  const outer = scene.put(layer, `${key}-box`, "svg", { x, y, width, height });
  let path = outer.firstElementChild;
  if (!path) {
    path = outer.ownerDocument.createElementNS(outer.namespaceURI, "path");
    outer.append(path);
  }
  const inside = points.map(([px, py]) => [px - x, py - y]);
  for (const [name, value] of Object.entries({ ...attributes, d: pathThrough(inside) })) {
    path.setAttribute(name, value);
  }
  return path;
}
