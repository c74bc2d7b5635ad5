// Decodes a packed plan (services/console/plan_packer.h) while it comes, without a copy of it.

const cells = 512;
const headerBytes = 24 + 4 * (cells + 1);
const magic = 'INTPLAN2';

export class PlanDecoder {
  count = 0;
  sizeMm = [0, 0, 0];
  starts = new Uint32Array(cells + 1);
  /** x, y, z and place in the order of each point, in 1/65535. */
  points = new Uint16Array(0);
  /** Of each place in the order: where its point is in `points`. */
  index = new Uint32Array(0);
  private header = new Uint8Array(headerBytes);
  private received = 0;
  private place = new Uint8Array(4);  // of which some bytes have come

  /** False until the header has come. */
  get hasHeader(): boolean {
    return this.received >= headerBytes;
  }

  get hasPoints(): boolean {
    return this.hasHeader && this.received >= headerBytes + 8 * this.count;
  }

  get isWhole(): boolean {
    return this.hasHeader && this.received === headerBytes + 12 * this.count;
  }

  /** The next bytes; throws when they are no plan. */
  push(bytes: Uint8Array) {
    let rest = bytes;
    if (!this.hasHeader) {
      rest = this.copy(rest, this.header, this.received);
      if (this.hasHeader) this.readHeader();
    }
    if (this.hasHeader && !this.hasPoints)
      rest = this.copy(rest, new Uint8Array(this.points.buffer), this.received - headerBytes);
    if (rest.length) this.takePlaces(rest);
  }

  /** What does not fit any more. */
  private copy(bytes: Uint8Array, to: Uint8Array, at: number): Uint8Array {
    const taken = Math.min(bytes.length, to.length - at);
    to.set(bytes.subarray(0, taken), at);
    this.received += taken;
    return bytes.subarray(taken);
  }

  private readHeader() {
    const view = new DataView(this.header.buffer);
    if (String.fromCharCode(...this.header.subarray(0, 8)) !== magic)
      throw new Error('the plan is of another version of the console');
    this.count = view.getUint32(8, true);
    this.sizeMm = [12, 16, 20].map((at) => view.getFloat32(at, true));
    for (let cell = 0; cell <= cells; ++cell)
      this.starts[cell] = view.getUint32(24 + 4 * cell, true);
    if (this.starts.some((start, cell) => start > this.count ||
                         cell > 0 && start < this.starts[cell - 1]) ||
        this.starts[cells] !== this.count)
      throw new Error('the cells of the plan are damaged');
    this.points = new Uint16Array(4 * this.count);
    this.index = new Uint32Array(this.count);
  }

  private takePlaces(bytes: Uint8Array) {
    const begin = headerBytes + 8 * this.count;
    if (this.received + bytes.length > begin + 4 * this.count)
      throw new Error('the plan is longer than its points');
    let next = this.received - begin;
    for (let i = 0; i < bytes.length;) {
      if ((next & 3) === 0 && i + 4 <= bytes.length) {
        this.put(next >> 2, bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]);
        next += 4;
        i += 4;
        continue;
      }
      this.place[next & 3] = bytes[i++];  // a place that comes in two parts
      if ((next++ & 3) === 3)
        this.put(next - 1 >> 2, this.place[0], this.place[1], this.place[2], this.place[3]);
    }
    this.received += bytes.length;
  }

  private put(at: number, a: number, b: number, c: number, d: number) {
    const place = (a | b << 8 | c << 16 | d << 24) >>> 0;
    if (place >= this.count) throw new Error('the order of the plan is damaged');
    this.index[place] = at;
  }
}
