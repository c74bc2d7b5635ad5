// The points of a job, as the graphics card has them.
import * as THREE from 'three';
import { Picture } from './cells';
import { PlanDecoder } from './plan';

const faint = 0.16;

export class Cloud {
  readonly group = new THREE.Group();
  readonly sides: number[];  // of the block; the longest is 1
  made = 0;
  next = 0;  // record of the journal
  readonly picture: Picture;
  private state: Uint8Array;
  private frame: THREE.Box3Helper;
  private fresh: THREE.Points | undefined;  // made since the last frame
  private outcomes: THREE.BufferAttribute;
  private cells: THREE.Points[] = [];

  constructor(private plan: PlanDecoder) {
    const longest = Math.max(...plan.sizeMm, 1e-9);
    this.sides = plan.sizeMm.map((mm) => mm / longest);
    this.picture = new Picture(plan.starts);
    this.state = new Uint8Array(plan.count);
    this.outcomes = new THREE.BufferAttribute(this.state, 1);
    this.outcomes.setUsage(THREE.DynamicDrawUsage);
    const positions = positionsOf(plan.points);
    for (let cell = 0; cell < 512; ++cell) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', positions);
      geometry.setAttribute('outcome', this.outcomes);
      const points = this.inBlock(geometry);
      points.visible = false;
      this.cells.push(points);
      if (this.picture.size(cell)) this.group.add(points);
    }
    const [x, y, z] = this.sides;
    const corner = new THREE.Vector3().set(-0.5 * x, -0.5 * y, -0.5 * z);
    this.frame = new THREE.Box3Helper(new THREE.Box3(corner, corner.clone().negate()), 0x5b6a7a);
    this.group.add(this.frame);
  }

  get count(): number {
    return this.plan.count;
  }

  /** Its order has come, too: it can show what is made. */
  get isLoaded(): boolean {
    return this.plan.isWhole;
  }

  /** All that can be seen is in the picture. */
  get isWhole(): boolean {
    return this.picture.isWhole && !this.fresh;
  }

  private inBlock(geometry: THREE.BufferGeometry): THREE.Points {
    const [x, y, z] = this.sides;
    const points = new THREE.Points(geometry, material);
    points.frustumCulled = false;
    points.scale.set(x, y, z);
    points.position.set(-0.5 * x, -0.5 * y, -0.5 * z);
    return points;
  }

  /** The picture is empty from now on. */
  restart(seen: boolean[]) {
    this.picture.clear(seen);
    this.frame.visible = true;
    this.forget();
  }

  /** The next frame adds as many points to the picture, and those that were made since. */
  show(points: number): number {
    for (const cell of this.cells) cell.visible = false;
    return this.picture.add(points, (cell, first, count) => {
      this.cells[cell].visible = true;
      this.cells[cell].geometry.setDrawRange(first, count);
    });
  }

  /** What was made, and the frame of the block, are in the picture. */
  forget() {
    if (!this.fresh) return;
    this.group.remove(this.fresh);
    this.fresh.geometry.dispose();
    this.fresh = undefined;
  }

  hideFrame() {
    this.frame.visible = false;
  }

  private addFresh(changed: number[]) {
    this.forget();
    const points = new Uint16Array(4 * changed.length);
    changed.forEach((at, to) =>
      points.set(this.plan.points.subarray(4 * at, 4 * at + 4), 4 * to));
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', positionsOf(points));
    geometry.setAttribute('outcome',
      new THREE.BufferAttribute(Uint8Array.from(changed, (at) => this.state[at]), 1));
    this.fresh = this.inBlock(geometry);
    this.group.add(this.fresh);
  }

  /** What was made (services/console/job_cloud.h); whether there is more, and whether the
   * picture has to be drawn again. */
  take(bytes: ArrayBuffer): { more: boolean; again: boolean } {
    const values = new Uint32Array(bytes);
    const changed: number[] = [];
    for (const value of values.subarray(1)) {
      const place = value & 0x1fffffff;
      if (place >= this.count) continue;
      const at = this.plan.index[place];
      if (this.state[at] !== 1 && value >>> 29 === 1) ++this.made;
      this.state[at] = value >>> 29;
      changed.push(at);
    }
    const more = values[0] !== this.next;
    this.next = values[0];
    if (!changed.length) return { more, again: false };
    this.outcomes.needsUpdate = true;
    // When the last of them are not in the picture yet, it is drawn from its begin.
    if (this.fresh) return { more, again: true };
    this.addFresh(changed);
    return { more, again: false };
  }

  dispose() {
    this.forget();
    for (const cell of this.cells) cell.geometry.dispose();
  }
}

function positionsOf(points: Uint16Array): THREE.InterleavedBufferAttribute {
  return new THREE.InterleavedBufferAttribute(
    new THREE.InterleavedBuffer(points, 4), 3, 0, true);
}

const material = new THREE.ShaderMaterial({
  transparent: true,
  depthWrite: false,
  vertexShader: `attribute float outcome; varying vec4 shade;
    void main() {
      bool made = outcome > .5 && outcome < 1.5;
      shade = outcome < .5 ? vec4(.55, .7, .9, ${faint}) : made ? vec4(1., 1., 1., .95)
                                                             : vec4(1., .45, .1, 1.);
      gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.);
      gl_PointSize = outcome < .5 ? 1.5 : 2.2;
    }`,
  fragmentShader: 'varying vec4 shade; void main() { gl_FragColor = shade; }',
});
