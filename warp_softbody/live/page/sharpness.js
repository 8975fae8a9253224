// Pixels of the picture for one of the page: fewer while pictures come too slowly.

const SLOW = 36;
const QUICK = 24;
const LEAST = 0.5;
const SHARPER = 1.15;
const COARSER = 0.8;
const PATIENCE = 6;
const PAUSE = 300;

export class Sharpness {
  constructor() {
    this.ratio = this.full();
    this.last = null;
    this.mean = QUICK;
    this.count = 0;
  }

  full() {
    return Math.min(2, window.devicePixelRatio);
  }

  /** The ratio for a picture at a time, ms, by how long the last ones took. */
  after(now) {
    const took = this.last === null ? PAUSE : now - this.last;
    this.last = now;
    if (took >= PAUSE && this.count === 0) return this.ratio;
    this.mean += 0.25 * (Math.min(took, PAUSE) - this.mean);
    this.count += 1;
    if (this.count < PATIENCE) return this.ratio;
    this.count = 0;
    if (this.mean > SLOW) this.ratio = Math.max(LEAST, COARSER * this.ratio);
    else if (this.mean < QUICK) this.ratio = Math.min(this.full(), SHARPER * this.ratio);
    return this.ratio;
  }

  /** The ratio where nothing moves; the next picture begins to measure anew. */
  rest() {
    this.last = null;
    this.count = 0;
    return this.full();
  }
}
