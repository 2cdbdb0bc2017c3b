/** The poses (3n) of a map that is told by its steps, in `unit` m and without headings. */
export function posesOf(steps, unit) {
  let [x, y] = [0, 0];
  return Array.from({ length: steps.length / 2 }, (_, k) => {
    [x, y] = [x + unit * steps[2 * k], y + unit * steps[2 * k + 1]];
    return [x, y, 0];
  }).flat();
}
