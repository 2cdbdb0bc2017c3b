import { numberText } from "./number.js";
import { lineBetween } from "./scene.js";
import { sideBySide } from "./stage.js";

const [LEFT, TOP, BOTTOM, RIGHT, APART, WIDEST] = [46, 28, 40, 4, 14, 34];

/**
 * A strip of values in the box `{x, y, width, height}` (pixels): bars over a linear axis, and over a
 * logarithmic one, which has no zero, dots. Each of `groups` is `{name, share, bars}`: the share of
 * the width that it takes, and its values `{value, look?, style?, part?}`; `part` is the key of the edge
 * that one measures. `axis` is `{domain: [low, high], ticks, label, line?: value, linear?}`. A
 * value below `low` is drawn there.
 */
export function putStrip(scene, layer, key, box, groups, axis) {
  const inner = {
    x: box.x + LEFT, y: box.y + TOP, width: box.width - LEFT - RIGHT, height: box.height - TOP - BOTTOM,
  };
  const parts = sideBySide(inner, groups.map(({ share }) => share), APART);
  const toY = stripScale(inner, axis);
  putStripAxis(scene, layer, key, inner, toY, axis);
  groups.forEach((group, k) => {
    putGroup(scene, layer, `${key}-${k}`, { ...parts[k], y: inner.y, height: inner.height }, toY, group, axis);
  });
}

/** From a value to pixels over the height of `inner`. */
function stripScale(inner, { domain: [low, high], linear }) {
  const floor = inner.y + inner.height;
  const share = linear
    ? (value) => (value - low) / (high - low)
    : (value) => Math.log(value / low) / Math.log(high / low);
  return (value) => floor - inner.height * Math.min(1, Math.max(0, share(Math.max(value, low))));
}

function putStripAxis(scene, layer, key, inner, toY, { ticks, label, line }) {
  for (const value of ticks) {
    const y = toY(value);
    scene.path(layer, `${key}-y-${value}`, "rs-grid", `M${inner.x} ${y}h${inner.width}`);
    scene.text(layer, `${key}-yt-${value}`, inner.x - 6, y + 5, numberText(value), "rs-tick", "end");
  }
  scene.text(layer, `${key}-yl`, inner.x - LEFT + 2, inner.y - TOP + 15, label);
  if (!line) return;
  const y = toY(line);
  scene.put(layer, `${key}-line`, "path", {
    class: "is-muted", d: `M${inner.x} ${y}h${inner.width}`, "stroke-dasharray": "5 4",
  });
}

function putGroup(scene, layer, key, inner, toY, { name, bars }, { linear }) {
  const floor = inner.y + inner.height;
  const slot = Math.min(WIDEST, inner.width / Math.max(bars.length, 1));
  const first = inner.x + 0.5 * (inner.width - slot * bars.length);
  bars.forEach(({ value, look = "is-muted", style = "", part }, number) => {
    const [x, y] = [first + (number + 0.5) * slot, toY(value)];
    const own = linear
      ? { class: look, "stroke-width": ((slot > 8 ? 0.6 : 0.8) * slot).toFixed(1) } : { class: "rs-dots" };
    const ends = lineBetween([x, linear ? floor : y], [x, y]);
    const cap = linear ? "stroke-linecap:butt;stroke-dasharray:none" : "";
    scene.put(layer, `${key}-${number}`, "line", { ...own, ...ends, "data-part": part, style: `${style};${cap}` });
  });
  scene.text(layer, `${key}-name`, inner.x + 0.5 * inner.width, floor + 18, name, "", "middle");
}
