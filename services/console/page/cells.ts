// Which points of a cloud a frame draws. A cloud has 8 x 8 x 8 cells with its points, in each
// cell in a random order; so the same share of each cell in view is a fair picture.

/** While the view moves: as many points as let a frame take its time, 20 to 30 a second. */
export class FrameBudget {
  static readonly least = 20000;
  static readonly most = 4e6;
  points = 100000;

  /** `full`: the frame drew as many points as the budget lets. */
  follow(tookMs: number, full: boolean) {
    if (tookMs > 50) this.points = Math.max(FrameBudget.least, this.points * 0.8);
    else if (tookMs < 34 && full) this.points = Math.min(this.points * 1.1, FrameBudget.most);
  }
}

/** Where a person looks from: around the middle of the block, whose longest side is 1. */
export interface Place {
  around: number;  // rad
  above: number;   // rad
  distance: number;
}

/** The angle of view, from the lowest to the highest line of the picture. */
export const viewDegrees = 45;

function dot(a: number[], b: number[]): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** Whether any point of each cell of a block with these sides can be in the picture; `aspect`:
 * its width by its height. */
export function cellsInView(sides: number[], from: Place, aspect: number): boolean[] {
  const { around, above, distance } = from;
  const outward = [Math.cos(around) * Math.cos(above), Math.sin(around) * Math.cos(above),
                   Math.sin(above)];
  const right = [-Math.sin(around), Math.cos(around), 0];
  const up = [-Math.cos(around) * Math.sin(above), -Math.sin(around) * Math.sin(above),
              Math.cos(above)];
  const radius = Math.hypot(...sides) / 16;
  const tangent = Math.tan(viewDegrees * Math.PI / 360);
  const reach = (depth: number, slope: number) =>
    depth * slope + radius * Math.hypot(1, slope);
  const seen: boolean[] = [];
  for (let cell = 0; cell < 512; ++cell) {
    const middle = [cell >> 6, cell >> 3 & 7, cell & 7]
      .map((step, axis) => ((step + 0.5) / 8 - 0.5) * sides[axis]);
    const depth = distance - dot(middle, outward);
    seen.push(depth > -radius &&
              Math.abs(dot(middle, right)) <= reach(depth, tangent * aspect) &&
              Math.abs(dot(middle, up)) <= reach(depth, tangent));
  }
  return seen;
}

/** What of each cell is in the picture. */
export class Picture {
  readonly drawn = new Uint32Array(512);
  private seen: boolean[] = [];
  private inView = 0;
  private share = 0;  // nothing is in a picture that was not begun

  constructor(private starts: Uint32Array) {}

  /** The picture is empty, and these cells can be seen. */
  clear(seen: boolean[]) {
    this.seen = seen;
    this.drawn.fill(0);
    this.inView = 0;
    seen.forEach((is, cell) => (this.inView += is ? this.size(cell) : 0));
    this.share = this.inView ? 0 : 1;
  }

  size(cell: number): number {
    return this.starts[cell + 1] - this.starts[cell];
  }

  get isWhole(): boolean {
    return this.share >= 1;
  }

  /** Calls `draw` for the points of each cell that come into the picture now. */
  add(points: number, draw: (cell: number, first: number, count: number) => void): number {
    if (this.isWhole) return 0;
    this.share = Math.min(1, this.share + points / this.inView);
    let added = 0;
    for (let cell = 0; cell < 512; ++cell) {
      const wanted = this.seen[cell] ? Math.ceil(this.share * this.size(cell)) : 0;
      const count = wanted - this.drawn[cell];
      if (count <= 0) continue;
      draw(cell, this.starts[cell] + this.drawn[cell], count);
      this.drawn[cell] = wanted;
      added += count;
    }
    return added;
  }
}
