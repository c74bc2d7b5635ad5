// Where the models are in their block, from above and from in front: boxes that a person drags,
// or moves by the arrow keys.
import { make } from './dom';
import { fill, text } from './text';

export type Place = [number, number, number];  // x, y, z, mm
export interface PlacedBox {
  name: string;
  low: Place;    // lowest corner in the block
  size: Place;
}

const keyStepMm = 1;
const finestMm = 0.1;
const edgeMm = 2;  // around the block
const svg = 'http://www.w3.org/2000/svg';

function shape(name: string, attributes: Record<string, string | number>): SVGElement {
  const element = document.createElementNS(svg, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  return element;
}

const round = (mm: number) => Math.round(mm / finestMm) * finestMm;

export class PlaceView {
  readonly element = make('div', '', 'places');
  private boxes: PlacedBox[] = [];
  private block: Place = [0, 0, 0];
  private margin = 0;
  private chosen = 0;

  /** `onMove`: a box is dragged, by so much since the last call. `onRest`: it is let go.
   * `onChoose`: somebody has touched it. */
  constructor(private onMove: (box: number, by: Place) => void, private onRest: () => void,
              private onChoose: (box: number) => void) {
    this.element.hidden = true;
  }

  /** What a preview found. */
  show(boxes: PlacedBox[], block: Place, margin: number, chosen: number) {
    Object.assign(this, { boxes, block, margin, chosen });
    this.element.hidden = !boxes.length;
    this.draw();
  }

  choose(box: number) {
    this.chosen = box;
    this.draw();
  }

  /** By numbers. */
  move(box: number, by: Place) {
    const moved = this.boxes[box];
    if (!moved) return;
    moved.low = moved.low.map((low, axis) => low + by[axis]) as Place;
    this.draw();
  }

  private isInside(box: PlacedBox): boolean {
    return box.low.every((low, axis) => low >= this.margin - 1e-6 &&
      low + box.size[axis] <= this.block[axis] - this.margin + 1e-6);
  }

  private draw() {
    const focused = (document.activeElement as SVGElement | null)?.dataset?.box;
    this.element.replaceChildren(this.view(text.fromAbove, 1), this.view(text.fromFront, 2));
    if (focused) this.element.querySelector<SVGElement>(`[data-box="${focused}"]`)?.focus();
  }

  /** x to the right, `up` (1: y, 2: z) upward. */
  private view(name: string, up: number): HTMLElement {
    const [wide, high] = [this.block[0], this.block[up]];
    const view = shape('svg', {
      viewBox: `${-edgeMm} ${-edgeMm} ${wide + 2 * edgeMm} ${high + 2 * edgeMm}`, role: 'group',
      'aria-label': name,
    });
    view.append(shape('rect', { x: 0, y: 0, width: wide, height: high, class: 'block' }));
    view.append(shape('rect', {
      x: this.margin, y: this.margin, width: Math.max(0, wide - 2 * this.margin),
      height: Math.max(0, high - 2 * this.margin), class: 'margin',
    }));
    this.boxes.forEach((box, number) => view.append(this.box(box, number, up, view)));
    const figure = make('figure');
    figure.append(make('figcaption', name, 'quiet'), view);
    return figure;
  }

  private box(box: PlacedBox, number: number, up: number, view: SVGElement): SVGElement {
    const state = this.isInside(box) ? '' : ' outside';
    const element = shape('rect', {
      x: box.low[0], y: this.block[up] - box.low[up] - box.size[up], tabindex: 0,
      width: Math.max(box.size[0], 0.5), height: Math.max(box.size[up], 0.5), role: 'button',
      class: `model${number === this.chosen ? ' chosen' : ''}${state}`,
      'data-box': `${number}-${up}`,
      'aria-label': fill(text.boxAt, {
        name: box.name, place: box.low.map((mm) => mm.toFixed(1)).join(' '),
      }),
    });
    element.addEventListener('pointerdown', (event) =>
      this.drag(event as PointerEvent, number, up, view));
    element.addEventListener('keydown', (event) => this.key(event as KeyboardEvent, number, up));
    element.addEventListener('focus', () => {
      if (this.chosen !== number) this.onChoose(number);
    });
    return element;
  }

  /** The listeners are those of the window: the box is drawn anew while it moves. */
  private drag(begin: PointerEvent, number: number, up: number, view: SVGElement) {
    if (!begin.isPrimary || begin.button !== 0) return;
    begin.preventDefault();
    const mmPerPixel = 1 / ((view as SVGGraphicsElement).getScreenCTM()?.a || 1);
    this.onChoose(number);
    let done: Place = [0, 0, 0];
    const move = (event: PointerEvent) => {
      const target: Place = [0, 0, 0];
      target[0] = round((event.clientX - begin.clientX) * mmPerPixel);
      target[up] = round((begin.clientY - event.clientY) * mmPerPixel);
      this.shift(number, target.map((mm, axis) => mm - done[axis]) as Place);
      done = target;
    };
    const end = () => {
      window.removeEventListener('pointermove', move);
      for (const kind of ['pointerup', 'pointercancel']) window.removeEventListener(kind, end);
      this.onRest();
    };
    window.addEventListener('pointermove', move);
    for (const kind of ['pointerup', 'pointercancel']) window.addEventListener(kind, end);
  }

  private key(event: KeyboardEvent, number: number, up: number) {
    const along: Record<string, [number, number]> = {
      ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowUp: [up, 1], ArrowDown: [up, -1],
    };
    const found = along[event.key];
    if (!found) return;
    event.preventDefault();
    const by: Place = [0, 0, 0];
    by[found[0]] = found[1] * keyStepMm;
    this.shift(number, by);
    this.onRest();
  }

  private shift(number: number, by: Place) {
    if (by.every((mm) => mm === 0)) return;
    this.onMove(number, by);
    this.move(number, by);
  }
}
