/** Pixels from which panels of a picture stand side by side. */
export const WIDE = 540;

/** Two parts of a box: side by side in these shares, or one above the other, the upper with `top` of the height. */
export function twoPanels(box, shares, top, gap) {
  if (box.width >= WIDE) return sideBySide(box, shares, gap);
  const height = top * box.height;
  return [{ ...box, height }, { ...box, y: box.y + height, height: box.height - height }];
}

/** The height of a drawing, in pixels: with question, control and readout it fits one screen. */
export function stageHeight(width) {
  return width < WIDE ? 375 : 380;
}

/** `{x, y, width, height}` cut from left to right into parts of these shares, `gap` pixels apart. */
export function sideBySide({ x, y, width, height }, shares, gap = 12) {
  const whole = shares.reduce((sum, share) => sum + share, 0);
  const room = width - gap * (shares.length - 1);
  let left = x;
  return shares.map((share) => {
    const part = { x: left, y, width: (room * share) / whole, height };
    left += part.width + gap;
    return part;
  });
}
