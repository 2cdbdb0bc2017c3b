/**
 * A small seeded source of random numbers, so that a picture shows the same draw each time.
 *
 * Source: Ettinger's mulberry32 for uniform numbers; Box and Muller 1958 for normal ones.
 */

/**
 * Return { uniform, normal, below } for a whole number `seed`: a number in [0, 1), a standard
 * normal one, and a whole number from 0 to n − 1.
 */
export function randomSource(seed) {
  let state = seed >>> 0;
  function uniform() {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), state | 1);
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61);
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
  }
  return {
    uniform,
    normal: () => Math.sqrt(-2 * Math.log(1 - uniform())) * Math.cos(2 * Math.PI * uniform()),
    below: (n) => Math.floor(n * uniform()),
  };
}
