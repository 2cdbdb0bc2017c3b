/** The two maps of the page *Your own graph*: drawn once; an edge and its cycle are marked on both. */
const SVG = "http://www.w3.org/2000/svg";
const [WIDTH, HEIGHT, MARGIN] = [360, 320, 16];
/** How near the pointer has to be, in the drawing's units. */
const NEAR = 12;

function put(parent, name, attributes, text = "") {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  parent.append(made);
  return made;
}

/** The round length, in m, of about a quarter of the drawing. */
function roundLength(metres) {
  const ten = 10 ** Math.floor(Math.log10(metres));
  return [5, 2, 1].map((one) => one * ten).find((length) => length <= metres) ?? ten;
}

/** A function from metres to the drawing's units, and how many of these a metre is. */
function fit(points) {
  const [x, y] = [0, 1].map((axis) => points.map((point) => point[axis]));
  // Spread into arguments, the coordinates of a large map would be too many.
  const [west, south] = [x, y].map((all) => all.reduce((a, b) => Math.min(a, b)));
  const [east, north] = [x, y].map((all) => all.reduce((a, b) => Math.max(a, b)));
  const scale = Math.min(
    (WIDTH - 2 * MARGIN) / Math.max(east - west, 1e-9),
    (HEIGHT - 3 * MARGIN) / Math.max(north - south, 1e-9),
  );
  const place = ([a, b]) => [
    WIDTH / 2 + scale * (a - (west + east) / 2),
    (HEIGHT - MARGIN) / 2 - scale * (b - (south + north) / 2),
  ];
  return { place, scale };
}

/** The `d` of a path of these edges. */
function segments(pixels, edges) {
  const at = ([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`;
  return edges.map(([i, j]) => `M${at(pixels[i])}L${at(pixels[j])}`).join("");
}

/** Which edges there are of each kind, by the class with which they are drawn. */
export function kinds({ edges, steps, kept }) {
  const found = { "is-kept": [], "is-step": [], "is-rejected": [] };
  edges.forEach((_, k) => {
    found[!kept[k] ? "is-rejected" : steps[k] ? "is-step" : "is-kept"].push(k);
  });
  return found;
}

/** The edges along which the two ends of edge `k` hang together without it; none, if nothing does. */
function cycleOf({ edges, trunk, names }, k) {
  const around = names.map(() => []);
  edges.forEach(([i, j], e) => {
    if (!trunk[e] || e === k) return;
    around[i].push([j, e]);
    around[j].push([i, e]);
  });
  const [first, last] = edges[k];
  const before = new Map([[first, null]]);
  for (let queue = [first]; queue.length && !before.has(last);) {
    const next = [];
    for (const at of queue) {
      for (const [to, e] of around[at]) {
        if (!before.has(to)) before.set(to, [at, e]) && next.push(to);
      }
    }
    queue = next;
  }
  const found = [];
  for (let step = before.get(last); step; step = before.get(step[0])) found.push(step[1]);
  return found;
}

/** Draw both maps into `places`, by name, and call `pick(k)` with the edge that is pointed at. */
export class Maps {
  #data;
  #panels;

  constructor(places, data, pick) {
    this.#data = data;
    this.#panels = Object.entries(places).map(([name, place]) => drawn(place, data, data[name]));
    for (const panel of this.#panels) {
      for (const kind of ["pointermove", "pointerdown"]) {
        panel.root.addEventListener(kind, (event) => {
          const k = nearest(panel, data, event);
          if (k >= 0) pick(k);
        });
      }
    }
  }

  /** Mark an edge and its cycle; return how many steps the cycle has. */
  mark(k) {
    const { edges } = this.#data;
    const cycle = cycleOf(this.#data, k);
    for (const { pixels, cyclePath, edgePath } of this.#panels) {
      cyclePath.setAttribute("d", segments(pixels, cycle.map((e) => edges[e])));
      edgePath.setAttribute("d", segments(pixels, [edges[k]]));
    }
    return cycle.length;
  }

  /** Both maps side by side as one drawing, in the colours that the page has now. */
  picture(titles) {
    const root = document.createElementNS(SVG, "svg");
    const [width, height] = [2 * WIDTH, HEIGHT + 24];
    const size = { xmlns: SVG, width, height, viewBox: `0 0 ${width} ${height}` };
    for (const [key, value] of Object.entries(size)) root.setAttribute(key, value);
    const ground = getComputedStyle(this.#panels[0].root).backgroundColor;
    put(root, "rect", { width, height, fill: ground });
    this.#panels.forEach((panel, side) => {
      const group = put(root, "g", { transform: `translate(${side * WIDTH} 24)` });
      const fill = getComputedStyle(panel.root).color;
      const font = { "font-family": "sans-serif", "font-size": 13 };
      put(group, "text", { x: MARGIN, y: -6, fill, ...font }, titles[side]);
      for (const part of panel.root.children) group.append(styled(part));
    });
    return new XMLSerializer().serializeToString(root);
  }
}

/** A copy of a part that needs no style sheet. */
function styled(part) {
  const copy = part.cloneNode(true);
  const style = getComputedStyle(part);
  const kept = ["fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap",
    "font-size"];
  for (const name of kept) copy.setAttribute(name, style.getPropertyValue(name));
  copy.setAttribute("font-family", "sans-serif");
  copy.removeAttribute("class");
  return copy;
}

function drawn(place, data, points) {
  const { place: toPixels, scale } = fit(points);
  const pixels = points.map(toPixels);
  const root = document.createElementNS(SVG, "svg");
  root.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
  root.setAttribute("aria-hidden", "true");
  for (const [look, found] of Object.entries(kinds(data))) {
    put(root, "path", { class: look, d: segments(pixels, found.map((k) => data.edges[k])) });
  }
  const cyclePath = put(root, "path", { class: "is-cycle" });
  const edgePath = put(root, "path", { class: "is-chosen" });
  const [x, y] = pixels[0];
  put(root, "circle", { class: "is-start", cx: x.toFixed(1), cy: y.toFixed(1), r: 4 });
  const length = roundLength((WIDTH / 4) / scale);
  const end = MARGIN + scale * length;
  put(root, "path", { class: "is-scale", d: `M${MARGIN} ${HEIGHT - 8}H${end.toFixed(1)}` });
  const name = `${length < 1 ? length.toPrecision(1) : length.toLocaleString("en")} m`;
  put(root, "text", { x: (end + 6).toFixed(1), y: HEIGHT - 4 }, name);
  place.replaceChildren(root);
  return { root, pixels, cyclePath, edgePath };
}

/** The edge nearest to the pointer, closures before odometry; −1 where none is near. */
function nearest({ root, pixels }, { edges, steps, kept }, event) {
  const box = root.getBoundingClientRect();
  const x = (event.clientX - box.left) * (WIDTH / box.width);
  const y = (event.clientY - box.top) * (HEIGHT / box.height);
  let [best, least] = [-1, NEAR];
  edges.forEach(([i, j], k) => {
    const [[ax, ay], [bx, by]] = [pixels[i], pixels[j]];
    const [dx, dy] = [bx - ax, by - ay];
    const along = ((x - ax) * dx + (y - ay) * dy) / Math.max(dx * dx + dy * dy, 1e-9);
    const t = Math.min(1, Math.max(0, along));
    const distance = Math.hypot(x - ax - t * dx, y - ay - t * dy)
      + (steps[k] && kept[k] ? NEAR / 3 : 0);
    if (distance < least) [best, least] = [k, distance];
  });
  return best;
}
