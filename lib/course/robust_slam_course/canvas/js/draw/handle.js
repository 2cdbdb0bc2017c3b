import { KEYS_STAY, setAttributes } from "./scene.js";

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };

/** To the ends of a range, and by a tenth of it, as from a value `now`. */
const KEYS = {
  Home: ({ now, least }) => least - now,
  End: ({ now, most }) => most - now,
  PageDown: ({ least, most }) => (least - most) / 10,
  PageUp: ({ least, most }) => (most - least) / 10,
};

/**
 * A handle that mouse, touch and keyboard move. `options`:
 * - `x`, `y`: where it is, in the scene's pixels; `shape`: "circle", "square" or "diamond"
 * - `label`, `text`, `now`, `least`, `most`: its name, and its value as words and as a number
 * - `drag(x, y)`: the pointer is at these pixels
 * - `step(right, up)`: a key, in steps, of which an arrow is one and with Shift ten; `unit`: how much a
 *   step changes the value, 1 where absent
 * - `remove()`: Delete or Backspace, where there is something to remove
 * - `look`: a class of the style sheet
 */
export function putHandle(scene, key, options) {
  const element = scene.put("handles", key, "g", {
    class: `rs-handle ${options.look ?? ""}`,
    role: "slider",
    tabindex: 0,
    transform: `translate(${options.x.toFixed(1)} ${options.y.toFixed(1)})`,
    "aria-label": options.label,
    "aria-valuetext": options.text,
    "aria-valuenow": options.now,
    "aria-valuemin": options.least,
    "aria-valuemax": options.most,
    "data-handle": key,
    ...KEYS_STAY,
  });
  if (!element.firstElementChild) listen(element, scene);
  drawHandle(element, options.shape ?? "circle");
  element.options = options;
  return element;
}

function drawHandle(element, shape) {
  const outlines = {
    circle: "M-9 0a9 9 0 1 0 18 0a9 9 0 1 0 -18 0Z",
    square: "M-8 -8H8V8H-8Z",
    diamond: "M0 -11L11 0L0 11L-11 0Z",
  };
  if (!element.firstElementChild) {
    // A finger needs 44 pixels; the ring around what is seen is the target.
    element.innerHTML = '<circle class="rs-target" r="22"></circle><path></path>';
  }
  setAttributes(element.lastElementChild, { d: outlines[shape] });
}

function listen(element, scene) {
  let grip = null;
  // Parts of a drawing ignore `touch-action`; without this the page would scroll with the handle.
  element.addEventListener("touchstart", (event) => event.preventDefault(), { passive: false });
  element.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    const at = scenePoint(scene, event);
    nearestHandle(scene, at).take(at, event.pointerId);
    event.preventDefault();
  });
  element.take = (at, pointer) => {
    // The handle keeps its distance to the finger, so that taking it moves nothing.
    grip = [element.options.x - at[0], element.options.y - at[1]];
    scene.held = true;
    element.setPointerCapture(pointer);
    element.focus({ preventScroll: true });
  };
  element.addEventListener("pointermove", (event) => {
    if (!grip) return;
    const at = scenePoint(scene, event);
    element.options.drag(at[0] + grip[0], at[1] + grip[1]);
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
    element.addEventListener(name, () => { grip = null; });
  }
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { remove, step, unit = 1 } = element.options;
    if (remove && (event.key === "Delete" || event.key === "Backspace")) remove();
    else if (ARROWS[event.key]) {
      const times = event.shiftKey ? 10 : 1;
      step(...ARROWS[event.key].map((count) => count * times));
    } else if (KEYS[event.key]) {
      const far = KEYS[event.key](element.options) / unit;
      step(0, Math.round(far) || Math.sign(far));
    } else return;
    event.preventDefault();
  });
}

/**
 * The handle nearest to a point in pixels: targets overlap, and the uppermost may be farther. Of those
 * at one place it is the one that was taken last, or the uppermost.
 */
function nearestHandle(scene, [x, y]) {
  const handles = [...scene.layers.get("handles").children].filter(({ take }) => take);
  const distance = (one) => Math.hypot(one.options.x - x, one.options.y - y) - (one === document.activeElement ? 4 : 0);
  return handles.reduce((best, other) => (distance(other) <= distance(best) ? other : best));
}

/** Where a pointer is, in the scene's pixels. */
function scenePoint(scene, event) {
  // Slides are scaled as a whole, which boxes on the screen do not tell.
  const toScene = scene.root.getScreenCTM().inverse();
  const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(toScene);
  return [x, y];
}
