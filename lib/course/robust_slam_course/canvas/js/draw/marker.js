const MARKERS = {
  circle: "M-5 0a5 5 0 1 0 10 0a5 5 0 1 0 -10 0Z",
  square: "M-4.5 -4.5H4.5V4.5H-4.5Z",
  triangle: "M0 -6L5.5 4.5H-5.5Z",
  diamond: "M0 -6L6 0L0 6L-6 0Z",
  plus: "M-2.5 -6.5H2.5V-2.5H6.5V2.5H2.5V6.5H-2.5V2.5H-6.5V-2.5H-2.5Z",
};

/** A filled marker at these pixels; `colour` is a variable of the style sheet without its prefix. */
export function putMarker(scene, layer, key, x, y, shape, colour) {
  return scene.put(layer, key, "path", {
    class: "rs-marker", d: MARKERS[shape],
    transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})`, style: `fill: var(--rs-${colour})`,
  });
}
