// Draws a block with its planned points (faint) and the cracks that were made, in a worker.
import * as THREE from 'three';
import { FrameBudget, cellsInView, viewDegrees } from './cells';
import { Cloud, Look, setLook } from './cloud';
import { Overlay } from './overlay';
import { PlanDecoder } from './plan';
import { Ticks } from './ticks';

const pollMs = 500;

let renderer: THREE.WebGLRenderer | undefined;
let camera: THREE.PerspectiveCamera;
let overlay: Overlay | undefined;
let look: Look = { mode: 'outcome', cut: [1, 1, 1], until: 1 };
let job: number | string = 0;  // number or uid; 0: none
let hidden = false;
let focusMm: number[] | undefined;  // of the machine that works on the job, in its glass
let turned = { around: 0.8, above: 0.5, distance: 2 };
let cloud: Cloud | undefined;
let isMoving = false;
const scene = new THREE.Scene();
const budget = new FrameBudget();

function place() {
  const { around, above, distance } = turned;
  camera.position.set(distance * Math.cos(around) * Math.cos(above),
                      distance * Math.sin(around) * Math.cos(above), distance * Math.sin(above));
  camera.up.set(0, 0, 1);
  camera.lookAt(0, 0, 0);
  camera.updateMatrixWorld();
}

function drawOverlay() {
  overlay?.draw(look.until >= 1 ? cloud : undefined, focusMm, look.cut, camera);
}

let isEmpty = false;  // the picture has to be cleared
let frames = 0;
// Of the frame before, when that drew points: its time shows how long a frame takes.
let before: { at: number; full: boolean } | undefined;

let isRunning = false;
/** Frame after frame while the page is in view. */
function run() {
  if (isRunning || !renderer || hidden) return;
  isRunning = true;
  requestAnimationFrame(frame);
}

function frame(now: number) {
  isRunning = false;
  run();
  const adds = !isMoving && !(cloud?.isWhole ?? true);
  if (!renderer || hidden || !isEmpty && !adds) {
    before = undefined;
    return;
  }
  if (before) budget.follow(now - before.at, before.full);
  if (isEmpty) {
    renderer.clear();
    cloud?.restart(cellsInView(cloud.sides, turned, camera.aspect));
    isEmpty = false;
  }
  const points = Math.round(budget.points);
  const added = cloud?.show(points) ?? 0;
  renderer.render(scene, camera);
  // Else frames would queue before the graphics card, and their time would not be theirs.
  renderer.getContext().finish();
  cloud?.forget();
  cloud?.hideFrame();
  before = cloud && { at: now, full: added >= points };
  drawOverlay();
  report();
}

function report() {
  const drawn = cloud?.picture.drawn.reduce((sum, count) => sum + count, 0) ?? 0;
  const isWhole = !!cloud && cloud.isWhole && !isMoving;
  postMessage({
    planned: cloud?.count ?? 0, made: cloud?.made ?? 0, drawn, frames: ++frames,
    budget: Math.round(budget.points), isLoaded: !!cloud?.isLoaded, isWhole,
  });
}

let resting: ReturnType<typeof setTimeout> | undefined;
/** As many points as the budget lets while the view moves; all, frame by frame, when it rests.
 * The last picture of the move stays, and the others are added to it. */
function moved() {
  isMoving = isEmpty = true;
  clearTimeout(resting);
  resting = setTimeout(() => (isMoving = false), 150);
}

function clear() {
  if (cloud) {
    scene.remove(cloud.group);
    cloud.dispose();
  }
  cloud = ticks = undefined;
  isEmpty = true;
}

/** Shows the points of a plan while its order is still coming. */
async function read(wanted: number | string, plan: ReadableStream<Uint8Array>) {
  const decoder = new PlanDecoder();
  const reader = plan.getReader();
  let shown: Cloud | undefined;
  for (;;) {
    const { done, value } = await reader.read();
    if (wanted !== job || shown !== undefined && shown !== cloud) return reader.cancel();
    if (value) decoder.push(value);
    if (!shown && decoder.hasPoints) {
      clear();
      shown = cloud = new Cloud(decoder);
      scene.add(cloud.group);
    }
    if (done) break;
  }
  if (!decoder.isWhole) clear();  // the connection broke; it is read again
  else report();
}

async function load(wanted: number | string) {
  try {
    const response = await fetch(`/api/v1/jobs/${wanted}/plan`);
    if (wanted !== job) return;
    if (response.status === 404) postMessage({ missing: true });
    if (response.ok && response.body) await read(wanted, response.body);
  } catch {
    if (wanted === job) clear();
  }
}

async function takeMade(of: Cloud): Promise<boolean> {
  try {
    const response = await fetch(`/api/v1/jobs/${job}/made?from=${of.next}`);
    const bytes = response.ok ? await response.arrayBuffer() : undefined;
    if (of !== cloud || !bytes) return false;
    const { more, again } = of.take(bytes);
    if (again) isEmpty = true;
    return more;
  } catch {
    return false;
  }
}

let ticks: Ticks | undefined;  // of the cloud

/** What the colours need that neither plan nor outcomes have; whether there is more. */
async function takeColours(of: Cloud): Promise<boolean> {
  const needs = look.mode === 'tick' ? 'ticks' : look.mode === 'channel' && !of.hasChannels ? 'channels' : '';
  if (!needs) return false;
  ticks ??= new Ticks(of.count);
  const wanted = ticks;
  try {
    const response = await fetch(`/api/v1/jobs/${job}/${needs}?from=${wanted.next}`);
    const bytes = response.ok ? await response.arrayBuffer() : undefined;
    if (of !== cloud || wanted !== ticks || !bytes) return false;
    if (needs === 'channels') of.takeChannels(bytes);
    if (needs === 'ticks' && bytes.byteLength <= 4) return false;
    const more = needs === 'ticks' && wanted.take(bytes);
    if (needs === 'ticks') of.takeTicks(wanted);
    isEmpty = true;
    return more;
  } catch {
    return false;
  }
}

let polling: ReturnType<typeof setTimeout> | undefined;
let loading: number | string = 0;  // the job whose plan is coming

let asking = 0;  // answers that are awaited

async function poll() {
  let more = false;
  ++asking;
  const wanted = job;
  if (wanted && !hidden && !cloud && loading !== wanted) {
    loading = wanted;
    await load(wanted);
    if (loading === wanted) loading = 0;
    more = wanted === job && !!cloud;
  } else if (!hidden && cloud?.isLoaded) {
    const of = cloud;
    more = await takeMade(of);
    more = await takeColours(of) || more;
    drawOverlay();
  }
  --asking;
  if (!hidden) pollIn(more ? 0 : pollMs);
}

function pollIn(ms: number) {
  clearTimeout(polling);
  polling = setTimeout(poll, ms);
}

onmessage = (event) => {
  const data = event.data;
  if (data.canvas) {
    renderer = new THREE.WebGLRenderer({
      canvas: data.canvas, antialias: false, preserveDrawingBuffer: true, depth: false,
      stencil: false,
    });
    renderer.autoClear = false;
    renderer.setSize(data.width, data.height, false);
    overlay = new Overlay(data.overlay, data.width, data.height);
    camera = new THREE.PerspectiveCamera(viewDegrees, data.width / data.height, 0.01, 20);
    place();
    run();
    pollIn(0);
  }
  if (data.resize && renderer && data.resize.height > 0) {
    renderer.setSize(data.resize.width, data.resize.height, false);
    overlay?.resize(data.resize.width, data.resize.height);
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
  if (data.look) {
    look = data.look;
    setLook(look);
    moved();
    if (!hidden && !asking) pollIn(0);
  }
  if ('focus' in data) {
    focusMm = data.focus;
    if (!hidden) drawOverlay();
  }
  if (data.hidden !== undefined) {
    hidden = data.hidden;
    run();
    // An answer that is awaited asks for the next one: the same records do not come twice.
    if (!hidden && !asking) pollIn(0);
  }
  if (data.job) {
    job = data.job;
    clear();
    pollIn(0);
  }
};
