/**
 * Labels beside the ends of lines, at pixel `x`. `labels` are `{y, text, colour}`, where colour
 * is a variable of the style sheet without its prefix. Labels that would overlap are moved
 * apart, in their order, within `low` and `high` (pixels).
 */
export function putEndLabels(scene, layer, key, x, labels, low, high) {
  const places = apart(labels.map(({ y }) => y), 16, low, high);
  labels.forEach(({ text, colour }, k) => {
    const style = `fill: var(--rs-${colour})`;
    scene.put(layer, `${key}-${k}`, "text", { x, y: places[k] + 5, style }, text);
  });
}

/** The heights `ys` moved apart until they differ by `gap`, in the same order. */
function apart(ys, gap, low, high) {
  const order = [...ys.keys()].sort((a, b) => ys[a] - ys[b] || a - b);
  const places = ys.map((y) => Math.min(high, Math.max(low, y)));
  for (let k = 1; k < order.length; k += 1) {
    places[order[k]] = Math.max(places[order[k]], places[order[k - 1]] + gap);
  }
  let ceiling = high;
  for (const k of order.reverse()) {
    places[k] = Math.min(places[k], ceiling);
    ceiling = places[k] - gap;
  }
  return places;
}

/**
 * The first of the places `[[x, y], …]` (pixels) that is `far` from all in `taken`, or the one
 * that is farthest from them; null where there is no place.
 */
export function freePlace(places, taken, far = 24) {
  const room = ([x, y]) => Math.min(Infinity, ...taken.map(([u, v]) => Math.hypot(u - x, v - y)));
  return places.find((place) => room(place) >= far)
    ?? places.reduce((best, place) => (best && room(best) >= room(place) ? best : place), null);
}
