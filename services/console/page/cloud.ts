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
      geometry.setAttribute('order', ordersOf(positions));
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
    const positions = positionsOf(points);
    geometry.setAttribute('position', positions);
    geometry.setAttribute('order', ordersOf(positions));
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

/** The fourth number of each point: its place in the order, 0..1. */
function ordersOf(positions: THREE.InterleavedBufferAttribute): THREE.InterleavedBufferAttribute {
  return new THREE.InterleavedBufferAttribute(positions.data, 1, 3, true);
}

/** What is shown of every cloud. */
export interface Look {
  byOrder: boolean;  // the colour of a crack is its place in the order
  cut: number[];     // only points up to here, of each side of the block, 0..1
  until: number;     // cracks up to this place in the order, 0..1
}

export function setLook(look: Look) {
  material.uniforms.byOrder.value = look.byOrder ? 1 : 0;
  material.uniforms.until.value = look.until;
  material.uniforms.cut.value.set(look.cut[0], look.cut[1], look.cut[2]);
}

const material = new THREE.ShaderMaterial({
  transparent: true,
  uniforms: {
    byOrder: { value: 0 }, until: { value: 1 }, cut: { value: new THREE.Vector3().set(1, 1, 1) },
  },
  depthWrite: false,
  vertexShader: `attribute float outcome, order; uniform float byOrder, until;
    uniform vec3 cut; varying vec4 shade;
    void main() {
      float state = order > until || until <= 0. ? 0. : outcome;
      bool made = state > .5 && state < 1.5;
      vec3 crack = byOrder < .5 ? vec3(1.) : mix(vec3(.25, .55, 1.), vec3(1., .8, .2), order);
      shade = state < .5 ? vec4(.55, .7, .9, ${faint}) : made ? vec4(crack, .95)
                                                           : vec4(1., .45, .1, 1.);
      gl_Position = any(greaterThan(position, cut))
        ? vec4(2., 2., 2., 1.) : projectionMatrix * modelViewMatrix * vec4(position, 1.);
      gl_PointSize = state < .5 ? 1.5 : 2.2;
    }`,
  fragmentShader: 'varying vec4 shade; void main() { gl_FragColor = shade; }',
});
