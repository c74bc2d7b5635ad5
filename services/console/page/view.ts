// Draws a block with its planned points (faint) and the cracks that were made, in a worker.
// services/console/job_cloud.h has the two formats.
import * as THREE from 'three';

const budget = 100000;
const pollMs = 500;
const faint = 0.16;

let renderer: THREE.WebGLRenderer | undefined;
let camera: THREE.PerspectiveCamera;
let job = 0;
let hidden = false;
let turned = { around: 0.8, above: 0.5, distance: 2 };
let cloud: Cloud | undefined;
let isDirty = true;
const scene = new THREE.Scene();

/** The points of a job, as the graphics card has them. */
class Cloud {
  readonly group = new THREE.Group();
  readonly count: number;
  made = 0;
  private index: Uint32Array;
  private state: Float32Array;
  private attribute: THREE.BufferAttribute;
  private geometry = new THREE.BufferGeometry();
  next = 0;

  constructor(bytes: ArrayBuffer) {
    const view = new DataView(bytes);
    this.count = view.getUint32(8, true);
    const size = [0, 1, 2].map((axis) => view.getFloat32(12 + 4 * axis, true));
    const longest = Math.max(...size, 1e-9);
    const points = new Uint16Array(bytes, 24, 4 * this.count);
    const places = new Uint32Array(bytes, 24 + 8 * this.count, this.count);
    this.index = new Uint32Array(this.count);
    places.forEach((place, at) => (this.index[place] = at));
    const buffer = new THREE.InterleavedBuffer(points, 4);
    this.geometry.setAttribute('position', new THREE.InterleavedBufferAttribute(buffer, 3, 0, true));
    this.state = new Float32Array(this.count);
    this.attribute = new THREE.BufferAttribute(this.state, 1);
    this.attribute.setUsage(THREE.DynamicDrawUsage);
    this.geometry.setAttribute('outcome', this.attribute);
    const drawn = new THREE.Points(this.geometry, material);
    drawn.frustumCulled = false;
    drawn.scale.set(size[0] / longest, size[1] / longest, size[2] / longest);
    drawn.position.set(-0.5 * drawn.scale.x, -0.5 * drawn.scale.y, -0.5 * drawn.scale.z);
    const box = new THREE.Box3(drawn.position.clone(), drawn.position.clone().negate());
    this.group.add(drawn, new THREE.Box3Helper(box, 0x5b6a7a));
  }

  limit(points: number) {
    this.geometry.setDrawRange(0, Math.min(points, this.count));
  }

  /** False: there is no more for now. */
  take(bytes: ArrayBuffer): boolean {
    const values = new Uint32Array(bytes);
    for (const value of values.subarray(1)) {
      const place = value & 0x1fffffff;
      if (place >= this.count) continue;
      const at = this.index[place];
      if (this.state[at] !== 1 && value >>> 29 === 1) ++this.made;
      this.state[at] = value >>> 29;
    }
    const more = values[0] !== this.next;
    this.next = values[0];
    if (values.length > 1) this.attribute.needsUpdate = true;
    return more;
  }

  dispose() {
    this.geometry.dispose();
  }
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

function frame() {
  requestAnimationFrame(frame);
  if (!renderer || !isDirty || hidden) return;
  isDirty = false;
  renderer.render(scene, camera);
  postMessage({ planned: cloud?.count ?? 0, made: cloud?.made ?? 0, drawn: cloud?.count ?? 0 });
}

let resting: ReturnType<typeof setTimeout> | undefined;
/** Few points while the view moves, all when it rests. */
function moved() {
  cloud?.limit(budget);
  isDirty = true;
  clearTimeout(resting);
  resting = setTimeout(() => {
    cloud?.limit(Infinity);
    isDirty = true;
  }, 150);
}

function clear() {
  if (cloud) {
    scene.remove(cloud.group);
    cloud.dispose();
  }
  cloud = undefined;
  isDirty = true;
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
  cloud.limit(Infinity);
  scene.add(cloud.group);
}

async function poll() {
  const of = cloud;
  const wanted = job;
  if (wanted && !of && !hidden) await load(wanted);
  if (of && !hidden) {
    const bytes = await fetchBytes(`/api/v1/jobs/${wanted}/made?from=${of.next}`);
    if (of === cloud && bytes) {
      const before = of.made;
      const more = of.take(bytes);
      isDirty = isDirty || more || of.made !== before;
      if (more) {
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
    renderer = new THREE.WebGLRenderer({ canvas: data.canvas, antialias: false });
    renderer.setSize(data.width, data.height, false);
    camera = new THREE.PerspectiveCamera(45, data.width / data.height, 0.01, 20);
    place();
    frame();
    poll();
  }
  if (data.resize && renderer && data.resize.height > 0) {
    renderer.setSize(data.resize.width, data.resize.height, false);
    camera.aspect = data.resize.width / data.resize.height;
    camera.updateProjectionMatrix();
    isDirty = true;
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
