// The nearest of many points.

/** Finds the nearest of the first `n` of `points`, which has three numbers for each. */
export class Nearest {
  constructor(points, n) {
    this.points = points;
    this.rising = Uint32Array.from({ length: n }, (_, i) => i).sort((i, j) => points[3 * i + 1] - points[3 * j + 1]);
  }

  /** The number of the one that is nearest to a place. */
  to([x, y, z]) {
    const { points, rising } = this;
    let [best, nearest] = [Infinity, 0];
    const look = (from, step) => {
      for (let m = from; m >= 0 && m < rising.length; m += step) {
        const j = 3 * rising[m];
        const [dx, dy, dz] = [points[j] - x, points[j + 1] - y, points[j + 2] - z];
        if (dy * dy >= best) break;
        const gap = dx * dx + dy * dy + dz * dz;
        if (gap < best) [best, nearest] = [gap, rising[m]];
      }
    };
    const middle = this.firstFrom(y);
    look(middle, 1);
    look(middle - 1, -1);
    return nearest;
  }

  /** Where in the order those begin that are not below `y`. */
  firstFrom(y) {
    let [low, high] = [0, this.rising.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.points[3 * this.rising[middle] + 1] < y) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
