// At which time of the job each point was fired, in ticks, from what the console sends of the
// journal (services/console/job_cloud.h). Ticks begin anew with each power-up of the controller:
// those of the next follow directly.

const powerUp = 0xffffffff;

export class Ticks {
  /** Ticks since the first pulse of the job, by place in the order; 0: not fired. */
  readonly of: Float32Array;
  next = 0;  // record of the journal
  last = 0;  // of the newest pulse
  private begin: number | undefined;  // tick that counts as `base`; undefined: the next pulse's
  private base = 0;
  private known = false;  // a pulse has come

  constructor(count: number) {
    this.of = new Float32Array(count);
  }

  /** Whether there is more. */
  take(bytes: ArrayBuffer): boolean {
    const values = new Uint32Array(bytes);
    for (let at = 1; at + 1 < values.length; at += 2) {
      const [place, tick] = [values[at], values[at + 1]];
      if (place === powerUp) {
        this.begin = undefined;
        continue;
      }
      if (this.begin === undefined) {
        this.begin = tick;
        this.base = this.known ? this.last + 1 : 0;
        this.known = true;
      }
      const since = this.base + ((tick - this.begin) | 0);
      this.last = Math.max(this.last, since);
      if (place < this.of.length) this.of[place] = since;
    }
    const more = values[0] !== this.next;
    this.next = values[0];
    return more;
  }
}
