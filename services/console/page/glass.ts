// The block with its planned points and its cracks, as the page shows it.
import { Dict, make } from './dom';
import { GlassTools } from './glass_tools';
import { fillCounted, text } from './text';

const turnPx = 20;  // of a finger that turns as far as one press of an arrow key
const keys: Record<string, Dict> = {
  ArrowLeft: { turn: [-turnPx, 0] },
  ArrowRight: { turn: [turnPx, 0] },
  ArrowUp: { turn: [0, -turnPx] },
  ArrowDown: { turn: [0, turnPx] },
  '+': { zoom: 0.8 },
  '-': { zoom: 1.25 },
};

/** The block; drawn by a worker, so that this thread stays free for Stop. */
export class GlassView extends HTMLElement {
  private worker?: Worker;
  private line = make('div', text.noGlass, 'quiet');
  private tools = new GlassTools((look) => this.worker?.postMessage({ look }));
  private job: number | string = 0;  // number or uid; 0: none
  private marked = new Set<string>();
  private focusMm?: number[];  // as it is drawn

  connectedCallback() {
    const canvas = document.createElement('canvas');
    // What is drawn has no elements that a key could reach: the canvas takes the keys itself.
    canvas.setAttribute('role', 'application');
    canvas.setAttribute('aria-label', text.glassPicture);
    canvas.tabIndex = 0;
    // The beam is drawn over it, and takes neither keys nor fingers.
    const over = document.createElement('canvas');
    over.setAttribute('aria-hidden', 'true');
    const picture = make('div', '', 'picture');
    picture.append(canvas, over);
    this.append(picture, this.line, this.tools.element);
    if (!('transferControlToOffscreen' in canvas)) return;
    const offscreen = canvas.transferControlToOffscreen();
    const overlay = over.transferControlToOffscreen();
    this.worker = new Worker('/view.js');
    const size = () => ({ width: canvas.clientWidth, height: canvas.clientHeight });
    this.worker.postMessage({ hidden: document.hidden });
    this.worker.postMessage({ canvas: offscreen, overlay, ...size() },
      [offscreen, overlay]);
    new ResizeObserver(() => this.worker?.postMessage({ resize: size() })).observe(canvas);
    let from: [number, number] | undefined;
    canvas.addEventListener('pointerdown', (event) => {
      from = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener('pointerup', () => (from = undefined));
    canvas.addEventListener('pointermove', (event) => {
      if (!from) return;
      this.worker?.postMessage({ turn: [event.clientX - from[0], event.clientY - from[1]] });
      from = [event.clientX, event.clientY];
    });
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.worker?.postMessage({ zoom: Math.exp(event.deltaY / 500) });
    });
    canvas.addEventListener('keydown', (event) => {
      const act = keys[event.key];
      if (!act || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      this.worker?.postMessage(act);
    });
    this.worker.onmessage = (event) => this.report(event.data);
    document.addEventListener('visibilitychange', () =>
      this.worker?.postMessage({ hidden: document.hidden }));
  }

  private report(data: Dict) {
    if (data.missing) this.line.textContent = text.otherHost;
    else this.line.textContent = fillCounted(text.cracksMade, data.planned ?? 0, data);
    this.tools.follow(data.planned ?? 0);
    this.dataset.drawn = String(data.drawn ?? 0);
    this.dataset.frames = String(data.frames ?? 0);
    this.dataset.budget = String(data.budget ?? 0);
    this.mark('first picture', data.drawn > 0);
    this.mark('loaded', data.isLoaded);
    this.mark('all drawn', data.isLoaded && data.isWhole);
  }

  /** Keeps the time at which the present job has come so far, for measurements. */
  private mark(name: string, reached: boolean) {
    if (!reached || this.marked.has(name)) return;
    this.marked.add(name);
    performance.mark(`glass ${this.job}: ${name}`);
  }

  show(job: number | string) {
    if (job === this.job) return;
    this.job = job;
    this.marked.clear();
    this.worker?.postMessage({ job });
    this.tools.restart();
  }

  /** The job that is engraved, until somebody chose one. */
  follow(jobs: Dict[]) {
    if (this.job) return;
    const engraved = jobs.find((job) => ['engraving', 'paused', 'done'].includes(job.state));
    if (engraved) this.show(engraved.job);
  }

  /** Where the focus of the machine is that works on the job in view. */
  showFocus(jobs: Dict[], stages: Dict[]) {
    const shown = jobs.find((job) => job.job === this.job || job.uid === this.job);
    const found = shown && stages.find((stage) => stage.job === shown.uid)?.focus_mm;
    const focus = found && [found.x, found.y, found.z];
    // A machine at rest is not drawn again.
    if (String(focus) === String(this.focusMm)) return;
    this.focusMm = focus;
    this.worker?.postMessage({ focus });
  }
}
