// Draws a block with its planned points (faint) and the cracks that were made, in a worker.
// services/console/job_cloud.h has the two formats.
import * as THREE from 'three';

// While the view moves: as many points as let a frame take its time.
const leastBudget = 20000;
const frameMs = { short: 34, long: 50 };
let budget = 100000;
const pollMs = 500;
const faint = 0.16;

let renderer: THREE.WebGLRenderer | undefined;
let camera: THREE.PerspectiveCamera;
let job = 0;
let hidden = false;
let turned = { around: 0.8, above: 0.5, distance: 2 };
let cloud: Cloud | undefined;
let isMoving = false;
const scene = new THREE.Scene();

/** The points of a job, as the graphics card has them. */
class Cloud {
  readonly group = new THREE.Group();
  readonly count: number;
  made = 0;
  drawn = 0;  // of all points, since the picture was cleared
  private index: Uint32Array;
  private state: Uint8Array;
  private points: Uint16Array;
  private plan: THREE.Points;
  private frame: THREE.Box3Helper;
  private fresh: THREE.Points | undefined;  // made since the last frame
  private attribute: THREE.BufferAttribute;
  private geometry = new THREE.BufferGeometry();
  next = 0;

  constructor(bytes: ArrayBuffer) {
    const view = new DataView(bytes);
    this.count = view.getUint32(8, true);
    const size = [0, 1, 2].map((axis) => view.getFloat32(12 + 4 * axis, true));
    const longest = Math.max(...size, 1e-9);
    this.points = new Uint16Array(bytes, 24, 4 * this.count);
    const places = new Uint32Array(bytes, 24 + 8 * this.count, this.count);
    this.index = new Uint32Array(this.count);
    places.forEach((place, at) => (this.index[place] = at));
    setPoints(this.geometry, this.points);
    this.state = new Uint8Array(this.count);
    this.attribute = new THREE.BufferAttribute(this.state, 1);
    this.attribute.setUsage(THREE.DynamicDrawUsage);
    this.geometry.setAttribute('outcome', this.attribute);
    this.scale = size.map((mm) => mm / longest);
    this.plan = this.inBlock(this.geometry);
    const { position } = this.plan;
    this.frame = new THREE.Box3Helper(
      new THREE.Box3(position.clone(), position.clone().negate()), 0x5b6a7a);
    this.group.add(this.plan, this.frame);
  }

  private scale: number[];

  private inBlock(geometry: THREE.BufferGeometry): THREE.Points {
    const [x, y, z] = this.scale;
    const points = new THREE.Points(geometry, material);
    points.frustumCulled = false;
    points.scale.set(x, y, z);
    points.position.set(-0.5 * x, -0.5 * y, -0.5 * z);
    return points;
  }

  /** The next frame adds the next points to the picture, and those that were made since. Their
   * order is random: every first part of them is a fair sample. */
  show(points: number) {
    const count = Math.min(points, this.count - this.drawn);
    this.plan.visible = count > 0;
    this.frame.visible = this.drawn === 0;
    this.geometry.setDrawRange(this.drawn, count);
    this.drawn += count;
  }

  restart() {
    this.drawn = 0;
    this.forget();
  }

  /** What was made is in the picture. */
  forget() {
    if (!this.fresh) return;
    this.group.remove(this.fresh);
    this.fresh.geometry.dispose();
    this.fresh = undefined;
  }

  get isWhole(): boolean {
    return this.drawn === this.count && !this.fresh;
  }

  private addFresh(changed: number[]) {
    this.forget();
    const points = new Uint16Array(4 * changed.length);
    changed.forEach((at, to) => points.set(this.points.subarray(4 * at, 4 * at + 4), 4 * to));
    const geometry = new THREE.BufferGeometry();
    setPoints(geometry, points);
    geometry.setAttribute('outcome',
      new THREE.BufferAttribute(Uint8Array.from(changed, (at) => this.state[at]), 1));
    this.fresh = this.inBlock(geometry);
    this.group.add(this.fresh);
  }

  /** False: there is no more for now. */
  take(bytes: ArrayBuffer): boolean {
    const values = new Uint32Array(bytes);
    const changed: number[] = [];
    for (const value of values.subarray(1)) {
      const place = value & 0x1fffffff;
      if (place >= this.count) continue;
      const at = this.index[place];
      if (this.state[at] !== 1 && value >>> 29 === 1) ++this.made;
      this.state[at] = value >>> 29;
      changed.push(at);
    }
    const more = values[0] !== this.next;
    this.next = values[0];
    if (!changed.length) return more;
    this.attribute.needsUpdate = true;
    // When the last of them are not in the picture yet, it is drawn from its begin.
    if (this.fresh) isEmpty = true;
    else this.addFresh(changed);
    return more;
  }

  dispose() {
    this.forget();
    this.geometry.dispose();
  }
}

function setPoints(geometry: THREE.BufferGeometry, points: Uint16Array) {
  const buffer = new THREE.InterleavedBuffer(points, 4);
  geometry.setAttribute('position', new THREE.InterleavedBufferAttribute(buffer, 3, 0, true));
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

function place() {
  const { around, above, distance } = turned;
  camera.position.set(distance * Math.cos(around) * Math.cos(above),
                      distance * Math.sin(around) * Math.cos(above), distance * Math.sin(above));
  camera.up.set(0, 0, 1);
  camera.lookAt(0, 0, 0);
}

let lastFrame = 0;
let isEmpty = false;  // the picture has to be cleared

/** Frames that follow each other show how long one takes. */
function adapt(now: number) {
  const took = now - lastFrame;
  lastFrame = now;
  if (!isMoving || took > 1000) return;
  if (took > frameMs.long) budget = Math.max(leastBudget, budget * 0.8);
  else if (took < frameMs.short) budget = Math.min(budget * 1.1, 4e6);
}

function frame(now: number) {
  requestAnimationFrame(frame);
  if (!renderer || hidden || (!isEmpty && !isMoving && (cloud?.isWhole ?? true))) return;
  adapt(now);
  if (isEmpty || isMoving) {
    renderer.clear();
    cloud?.restart();
    isEmpty = false;
  }
  cloud?.show(Math.round(budget));
  renderer.render(scene, camera);
  cloud?.forget();
  postMessage({ planned: cloud?.count ?? 0, made: cloud?.made ?? 0, drawn: cloud?.drawn ?? 0 });
}

let resting: ReturnType<typeof setTimeout> | undefined;
/** As many points as the budget lets while the view moves; all, frame by frame, when it rests. */
function moved() {
  isMoving = isEmpty = true;
  clearTimeout(resting);
  resting = setTimeout(() => {
    isMoving = false;
    isEmpty = true;
  }, 150);
}

function clear() {
  if (cloud) {
    scene.remove(cloud.group);
    cloud.dispose();
  }
  cloud = undefined;
  isEmpty = true;
}

async function fetchBytes(path: string): Promise<ArrayBuffer | undefined> {
  try {
    const response = await fetch(path);
    return response.ok ? await response.arrayBuffer() : undefined;
  } catch {
    return undefined;
  }
}

async function load(wanted: number) {
  const bytes = await fetchBytes(`/api/v1/jobs/${wanted}/plan`);
  if (wanted !== job) return;
  if (!bytes) return postMessage({ missing: true });
  clear();
  cloud = new Cloud(bytes);
  scene.add(cloud.group);
}

async function poll() {
  const of = cloud;
  const wanted = job;
  if (wanted && !of && !hidden) await load(wanted);
  if (of && !hidden) {
    const bytes = await fetchBytes(`/api/v1/jobs/${wanted}/made?from=${of.next}`);
    if (of === cloud && bytes) {
      if (of.take(bytes)) {
        setTimeout(poll, 0);
        return;
      }
    }
  }
  setTimeout(poll, pollMs);
}

onmessage = (event) => {
  const data = event.data;
  if (data.canvas) {
    renderer = new THREE.WebGLRenderer({
      canvas: data.canvas, antialias: false, preserveDrawingBuffer: true,
    });
    renderer.autoClear = false;
    renderer.setSize(data.width, data.height, false);
    camera = new THREE.PerspectiveCamera(45, data.width / data.height, 0.01, 20);
    place();
    requestAnimationFrame(frame);
    poll();
  }
  if (data.resize && renderer && data.resize.height > 0) {
    renderer.setSize(data.resize.width, data.resize.height, false);
    camera.aspect = data.resize.width / data.resize.height;
    camera.updateProjectionMatrix();
    isEmpty = true;
  }
  if (data.turn) {
    turned.around -= data.turn[0] / 200;
    turned.above = Math.min(1.5, Math.max(-1.5, turned.above + data.turn[1] / 200));
    place();
    moved();
  }
  if (data.zoom) {
    turned.distance = Math.min(8, Math.max(0.3, turned.distance * data.zoom));
    place();
    moved();
  }
  if (data.hidden !== undefined) hidden = data.hidden;
  if (data.job) {
    job = data.job;
    clear();
  }
};
