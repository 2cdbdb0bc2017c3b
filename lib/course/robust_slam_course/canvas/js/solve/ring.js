/**
 * Headings of a ring of which each was measured to be turned by `alpha` (rad) from the one before.
 *
 * Source: coordinate descent on the cost of `connectionMatrix`, whose minimum over one heading is the
 * direction of the sum of the headings that its two neighbours expect.
 */
const RING_SWEEPS = 400;
const AT_REST = 1e-9; // rad by which a heading still moves
const PULL_STEP = Math.PI / 60; // rad by which a heading is pulled before the others follow

/** Return the headings (n,) in rad at which the cost rests while the first one and `held` stay. */
export function relaxedHeadings(headings, alpha, held = 0) {
  const [found, n] = [Array.from(headings), headings.length];
  for (let sweep = 0, moved = 1; sweep < RING_SWEEPS && moved > AT_REST; sweep++) {
    moved = 0;
    for (let i = 1; i < n; i++) {
      if (i === held) continue;
      const [left, right] = [found[i - 1] + alpha, found[(i + 1) % n] - alpha];
      const to = Math.atan2(Math.sin(left) + Math.sin(right), Math.cos(left) + Math.cos(right));
      moved = Math.max(moved, Math.abs(Math.sin(to - found[i])));
      found[i] = to;
    }
  }
  return found;
}

/**
 * Pull heading `held` by the turns in `path` (rad, from where it rests), one after another, while the
 * others follow. Return `steps` [{ turn, headings }, …], the start first.
 */
export function pulledRing(headings, alpha, held, path) {
  const steps = [{ turn: 0, headings }];
  for (const goal of path) {
    const from = steps.at(-1).turn;
    const count = Math.ceil(Math.abs(goal - from) / PULL_STEP - 1e-9);
    for (let k = 1; k <= count; k++) {
      const turn = from + ((goal - from) * k) / count;
      const before = steps.at(-1).headings.map((angle, i) => (i === held ? headings[held] + turn : angle));
      steps.push({ turn, headings: relaxedHeadings(before, alpha, held) });
    }
  }
  return steps;
}
