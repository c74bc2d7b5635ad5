// The points of a job, as the graphics card has them.
import * as THREE from 'three';
import { Picture } from './cells';
import { Mode, first, last, modes, ofChannel, ofOutcome } from './colours';
import { PlanDecoder } from './plan';
import { Ticks } from './ticks';

const faint = 0.16;

export class Cloud {
  readonly group = new THREE.Group();
  readonly sides: number[];  // of the block; the longest is 1
  made = 0;
  next = 0;  // record of the journal
  newest = -1;  // crack, by its place in the order; -1: none since the page shows the job
  newestAt = 0;  // ms, by performance.now()
  readonly picture: Picture;
  private isUpToDate = false;  // what was made before the page came is known
  private state: Uint8Array;
  private frame: THREE.Box3Helper;
  private fresh: THREE.Points | undefined;  // made since the last frame
  private outcomes: THREE.BufferAttribute;
  private cells: THREE.Points[] = [];
  private channels: Uint8Array | undefined;  // of each point, as `state`
  private ticks: Float32Array | undefined;
  private tickAttribute: THREE.BufferAttribute | undefined;

  constructor(private plan: PlanDecoder) {
    const longest = Math.max(...plan.sizeMm, 1e-9);
    this.sides = plan.sizeMm.map((mm) => mm / longest);
    this.picture = new Picture(plan.starts);
    this.state = new Uint8Array(plan.count);
    this.outcomes = bytesOf(this.state);
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

  get hasChannels(): boolean {
    return !!this.channels;
  }

  /** Where a point is in the scene, by its place in the order. */
  at(place: number): THREE.Vector3 {
    const from = 4 * this.plan.index[place];
    return this.inScene((axis) => this.plan.points[from + axis] / 65535);
  }

  /** Where a place of the glass is in the scene. */
  placeOf(mm: number[]): THREE.Vector3 {
    return this.inScene((axis) => mm[axis] / this.plan.sizeMm[axis]);
  }

  /** `share`: of each side of the block, 0..1 within it. */
  private inScene(share: (axis: number) => number): THREE.Vector3 {
    const [x, y, z] = this.sides.map((side, axis) => (share(axis) - 0.5) * side);
    return new THREE.Vector3().set(x, y, z);
  }

  /** The section leaves this point in the picture. */
  isWithin(place: number, cut: number[]): boolean {
    const from = 4 * this.plan.index[place];
    return cut.every((most, axis) => this.plan.points[from + axis] / 65535 <= most);
  }

  /** The places in the order of at most so many open points behind the newest crack. */
  following(count: number): number[] {
    const places: number[] = [];
    for (let place = this.newest + 1; place < this.count && places.length < count; ++place)
      if (this.state[this.plan.index[place]] === 0) places.push(place);
    return places;
  }

  private setAll(name: string, attribute: THREE.BufferAttribute) {
    for (const cell of this.cells) cell.geometry.setAttribute(name, attribute);
  }

  /** The channels of each point, by its place in the order. */
  takeChannels(bytes: ArrayBuffer) {
    const masks = new Uint8Array(bytes);
    if (masks.length !== this.count) return;
    this.channels = new Uint8Array(this.count);
    masks.forEach((mask, place) => (this.channels![this.plan.index[place]] = mask));
    this.setAll('channel', bytesOf(this.channels));
  }

  /** At which ticks points were fired. */
  takeTicks(ticks: Ticks) {
    this.ticks ??= new Float32Array(this.count);
    ticks.of.forEach((tick, place) => (this.ticks![this.plan.index[place]] = tick));
    if (!this.tickAttribute) {
      this.tickAttribute = new THREE.BufferAttribute(this.ticks, 1);
      this.tickAttribute.setUsage(THREE.DynamicDrawUsage);
      this.setAll('tick', this.tickAttribute);
    }
    this.tickAttribute.needsUpdate = true;
    material.uniforms.lastTick.value = Math.max(1, ticks.last);
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
    geometry.setAttribute('outcome', bytesOf(Uint8Array.from(changed, (at) => this.state[at])));
    const { channels, ticks } = this;
    if (channels) geometry.setAttribute('channel',
      bytesOf(Uint8Array.from(changed, (at) => channels[at])));
    if (ticks) geometry.setAttribute('tick',
      new THREE.BufferAttribute(Float32Array.from(changed, (at) => ticks[at]), 1));
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
      if (this.state[at] !== 1 && value >>> 29 === 1) {
        ++this.made;
        if (this.isUpToDate) [this.newest, this.newestAt] = [place, performance.now()];
      }
      this.state[at] = value >>> 29;
      changed.push(at);
    }
    const more = values[0] !== this.next;
    this.next = values[0];
    this.isUpToDate ||= !more;
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

// Formats that every graphics card reads as they are: of any other one its driver makes a copy
// in numbers of 4 bytes, and makes it again at each change.

/** x, y, z and place in the order of each point, 0..1. */
function positionsOf(points: Uint16Array): THREE.BufferAttribute {
  return new THREE.BufferAttribute(points, 4, true);
}

/** Small numbers; the shader gets them divided by 255. */
function bytesOf(values: Uint8Array): THREE.BufferAttribute {
  return new THREE.BufferAttribute(values, 1, true);
}

/** What is shown of every cloud. */
export interface Look {
  mode: Mode;        // what the colours show
  cut: number[];     // only points up to here, of each side of the block, 0..1
  until: number;     // cracks up to this place in the order, 0..1
}

export function setLook(look: Look) {
  material.uniforms.mode.value = modes.indexOf(look.mode);
  material.uniforms.until.value = look.until;
  material.uniforms.cut.value.set(look.cut[0], look.cut[1], look.cut[2]);
}

function glsl(colour: number[]): string {
  return `vec3(${colour.map((part) => part.toFixed(3)).join(', ')})`;
}

const material = new THREE.RawShaderMaterial({
  transparent: true,
  uniforms: {
    mode: { value: 0 }, until: { value: 1 }, cut: { value: new THREE.Vector3().set(1, 1, 1) },
    lastTick: { value: 1 },
  },
  depthWrite: false,
  vertexShader: `precision highp float;
    attribute vec4 position; attribute float outcome, tick, channel;
    uniform mat4 projectionMatrix, modelViewMatrix;
    uniform float mode, until, lastTick; uniform vec3 cut; varying vec4 shade;
    vec3 inChannels() {
      vec4 is = mod(floor((255. * channel + .5) / vec4(1., 2., 4., 8.)), 2.);
      return (${ofChannel.map((colour, i) => `is[${i}] * ${glsl(colour)}`).join(' + ')})
        / max(1., dot(is, vec4(1.)));
    }
    vec3 ofOutcome(float state) {
      return ${ofOutcome.slice(0, -1).map((colour, i) =>
        `state < ${i}.5 ? ${glsl(colour)} : `).join('')}${glsl(ofOutcome[ofOutcome.length - 1])};
    }
    void main() {
      float order = position.w;
      float state = order > until || until <= 0. ? 0. : 255. * outcome;
      bool made = state > .5 && state < 1.5, planned = state < .5;
      float along = mode < 1.5 ? order : tick / lastTick;
      vec3 colour = (planned || made) && mode > 2.5 ? inChannels()
        : made && mode > .5 ? mix(${glsl(first)}, ${glsl(last)}, along) : ofOutcome(state);
      shade = vec4(colour, planned ? ${faint} : made ? .95 : 1.);
      gl_Position = any(greaterThan(position.xyz, cut))
        ? vec4(2., 2., 2., 1.) : projectionMatrix * modelViewMatrix * vec4(position.xyz, 1.);
      gl_PointSize = state < .5 ? 1.5 : 2.2;
    }`,
  fragmentShader: `precision mediump float;
    varying vec4 shade; void main() { gl_FragColor = shade; }`,
});
