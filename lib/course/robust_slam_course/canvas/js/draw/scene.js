const SVG_NAMESPACE = "http://www.w3.org/2000/svg";

/** On what takes keys: JupyterLab leaves them to it, rather than to a shortcut of its own. */
export const KEYS_STAY = { "data-lm-suppress-shortcuts": true };

/** Set the attributes that differ; null or false removes one. */
export function setAttributes(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) element.removeAttribute(name);
    else if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
  }
}

/** A new SVG element. */
function svgElement(name, attributes = {}, parent = null) {
  const element = document.createElementNS(SVG_NAMESPACE, name);
  setAttributes(element, attributes);
  if (parent) parent.append(element);
  return element;
}

/**
 * A drawing whose parts have keys. Each pass between `begin` and `end` puts every part that
 * shall be seen; a part keeps its element from one pass to the next, so that focus and a
 * pointer's capture survive, and a part that is not put again is removed. `begin` names the
 * layers from back to front.
 */
export class Scene {
  constructor(parent, label) {
    this.root = svgElement("svg", { role: "group", "aria-label": label }, parent);
    this.layers = new Map();
    this.parts = new Map();
    this.seen = new Set();
    this.fits = new Map(); // sizes of maps, which stay while the hand that took a handle is in the drawing
    this.held = false;
    // All pictures of a page share one set of ids; the same state shall give the same drawing.
    this.name = `rs-${label.replace(/\W+/g, "-")}`;
  }

  /** Start a pass over a drawing of this size, in CSS pixels. */
  begin(width, height, layers) {
    setAttributes(this.root, { width, height, viewBox: `0 0 ${width} ${height}` });
    for (const name of layers) {
      if (!this.layers.has(name)) {
        const hidden = name === "handles" ? null : "true";
        this.layers.set(name, svgElement("g", { "aria-hidden": hidden }, this.root));
      }
    }
    this.seen.clear();
    this.order = new Map([...this.layers.keys()].map((name) => [name, []]));
  }

  /** Put a part into a layer and return its element. */
  put(layer, key, name, attributes, text = null) {
    let element = this.parts.get(key);
    if (!element) {
      element = svgElement(name, {}, this.layers.get(layer));
      this.parts.set(key, element);
    }
    this.order.get(layer).push(element);
    this.seen.add(key);
    setAttributes(element, attributes);
    if (text !== null && element.textContent !== text) element.textContent = text;
    return element;
  }

  /** Put a path `d` of the class `look`; without a `width` (pixels) its look has one. */
  path(layer, key, look, d, width = null) {
    return this.put(layer, key, "path", { class: look, d, "stroke-width": width });
  }

  /** Put words whose `anchor` ("start", "middle" or "end") is at (x, y). */
  text(layer, key, x, y, words, look = "", anchor = null) {
    return this.put(layer, key, "text", { class: look || null, x, y, "text-anchor": anchor }, words);
  }

  /** Let nothing of a layer be seen outside the box `{x, y, width, height}` (pixels). */
  clip(layer, { x, y, width, height }) {
    const id = `${this.name}-${layer}`;
    const path = this.put(layer, `clip-${layer}`, "clipPath", { id });
    if (!path.firstElementChild) svgElement("rect", {}, path);
    setAttributes(path.firstElementChild, { x, y, width, height });
    setAttributes(this.layers.get(layer), { "clip-path": `url(#${id})` });
  }

  /** End a pass: what was not put is removed, and the parts have the order of the pass. */
  end() {
    for (const [key, element] of this.parts) {
      if (this.seen.has(key)) continue;
      element.remove();
      this.parts.delete(key);
    }
    for (const [name, order] of this.order) {
      const layer = this.layers.get(name);
      if (order.every((element, k) => layer.children[k] === element)) continue;
      // To move the part that has the focus would take the focus away.
      const focused = order.indexOf(document.activeElement);
      order.forEach((element, k) => {
        if (focused < 0 || k > focused) layer.append(element);
        else if (k < focused) order[focused].before(element);
      });
    }
  }
}

/** The attributes of a line; unlike a path's `d` they are no style, which a browser would work out anew. */
export function lineBetween([x, y], [toX, toY]) {
  const [x1, y1, x2, y2] = [x, y, toX, toY].map((each) => each.toFixed(1));
  return { x1, y1, x2, y2 };
}

/** The `d` of a path through points `[[x, y], …]`, in pixels. */
export function pathThrough(points) {
  return points.map(([x, y], k) => `${k ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");
}
