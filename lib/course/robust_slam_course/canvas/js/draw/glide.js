const SETTLE = 70; // ms in which a movement covers 63 % of what is left

/**
 * Numbers that glide to where they shall be. `aim(target)` sets the goal; `advance(time)`
 * returns the numbers of this frame and whether they arrived. With `calm` they jump.
 */
export class Glide {
  constructor() {
    this.shown = null;
    this.target = null;
    this.time = null;
  }

  aim(target, calm) {
    if (calm || !this.shown || this.shown.length !== target.length) {
      this.shown = Float64Array.from(target);
    }
    this.target = target;
  }

  advance(time) {
    const share = this.time === null ? 0.2 : 1 - Math.exp(-(time - this.time) / SETTLE);
    this.time = time;
    let left = 0;
    for (let k = 0; k < this.target.length; k += 1) {
      this.shown[k] += share * (this.target[k] - this.shown[k]);
      left = Math.max(left, Math.abs(this.target[k] - this.shown[k]));
    }
    return left;
  }

  arrive() {
    this.shown.set(this.target);
    this.time = null;
  }
}
