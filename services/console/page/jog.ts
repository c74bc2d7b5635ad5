// A machine moved and taught by hand, by buttons that are held. While a finger is down, the page
// answers each state of the machine with one message; nothing else sends one. So it ends when the
// finger lifts, the page is hidden, the connection stalls, or somebody else takes over.
import { Dict, make, option } from './dom';
import { text } from './text';

export interface Order {
  kind: string;
  x?: number;
  y?: number;
  z?: number;
  channel?: number;
  lens?: string;
  sets?: number;  // of a zero: 1 x, 2 y, 4 z, or a sum
  x_max?: number;  // of limits
  y_max?: number;
  z_max?: number;
}

/** Of a button that is held. */
export interface Held {
  order: (view: Dict) => Order;
  /** Why it cannot be sent; "": it can. */
  why?: () => string;
  report?: (line: string) => void;
}

export class JogPanel extends HTMLElement {
  private machines = document.createElement('select');
  private step = document.createElement('select');
  private speed = document.createElement('input');
  private place = make('div', '', 'quiet');
  private buttons = make('div', '', 'jog');
  private answer = make('div', '', 'need');
  private view: Dict | undefined;  // of the machine that is shown
  private axes = '';
  private press = 0;
  private held: Held | undefined;
  private order: Order | undefined;  // of the press, once the machine's state is known
  private fresh = 0;  // states since the press
  send: (message: Dict) => void = () => {};
  /** Another machine is chosen. */
  onMachine: () => void = () => {};
  onView: (view: Dict) => void = () => {};

  connectedCallback() {
    this.speed.type = 'number';
    Object.assign(this.speed, { min: '0.1', max: '100', step: 'any', value: '10' });
    for (const [value, label] of [['0', text.whileHeld], ['0.01', '0.01'], ['0.1', '0.1'],
      ['1', '1'], ['10', '10']]) {
      this.step.append(option(value, label));
    }
    const line = (label: string, field: HTMLElement) => {
      const element = make('label', label);
      element.append(' ', field);
      return element;
    };
    this.machines.addEventListener('change', () => {
      this.letGo();
      this.onMachine();
    });
    this.answer.setAttribute('role', 'status');
    this.append(make('p', text.jogHint, 'quiet'), line(text.machine, this.machines),
      line(text.step, this.step), line(text.speedMmS, this.speed), this.place, this.buttons,
      this.answer);
    this.showAxes(['x', 'y', 'z']);
  }

  get machine(): string {
    return this.machines.value;
  }

  get speedMmS(): number {
    return Number(this.speed.value) || 0;
  }

  /** A button whose order is sent while it is held. */
  button(label: string, held: Held): HTMLButtonElement {
    const button = make('button', label, 'hold') as HTMLButtonElement;
    button.addEventListener('pointerdown', (event) => {
      if (event.isPrimary && event.button === 0) this.hold(held);
    });
    for (const end of ['pointerup', 'pointercancel', 'pointerleave', 'lostpointercapture',
      'keyup', 'blur'])
      button.addEventListener(end, () => this.letGo());
    button.addEventListener('contextmenu', (event) => event.preventDefault());
    button.addEventListener('keydown', (event) => {
      if (!event.repeat && (event.key === 'Enter' || event.key === ' ')) this.hold(held);
    });
    return button;
  }

  private showAxes(names: string[]) {
    if (this.axes === names.join()) return;
    this.axes = names.join();
    const along = names.flatMap((name, axis) => [-1, 1].map((sign) => this.button(
      `${name} ${sign < 0 ? '−' : '+'}`, { order: (view) => this.along(view, axis, sign) })));
    this.buttons.replaceChildren(...along,
      this.button(text.home, { order: () => ({ kind: 'home' }) }));
  }

  private along(view: Dict, axis: number, sign: number): Order {
    const step = Number(this.step.value);
    const values = view.axes.map((one: Dict, i: number) =>
      step ? one.position + (i === axis ? sign * step : 0) : i === axis ? sign : 0);
    const [x = 0, y = 0, z = 0] = values;
    return { kind: step ? 'move' : 'jog', x, y, z };
  }

  private report(held: Held, line: string) {
    if (held.report) held.report(line);
    else this.answer.textContent = line;
  }

  private hold(held: Held) {
    this.letGo();
    const why = held.why?.() ?? '';
    this.report(held, why);
    if (why) return;
    ++this.press;
    this.held = held;
    this.fresh = 0;
    this.message({ kind: '' }, '0');  // the machine's states come quickly from now on
  }

  letGo() {
    if (!this.held) return;
    this.held = this.order = undefined;
    this.message({ kind: '' }, this.view?.number ?? '0');
  }

  private message(order: Order, seen: string) {
    this.send({
      jog: {
        cell: this.machine, press: this.press, seen, channel: 1,
        speed_mm_s: this.speedMmS, ...order,
      },
    });
  }

  /** A state of the machine: the only thing that is answered by a sample. */
  take(view: Dict) {
    if (view.cell !== this.machine) return;
    this.view = view;
    this.showAxes(view.axes.map((axis: Dict) => axis.name));
    this.place.textContent = [...view.axes.map((axis: Dict) =>
      `${axis.name} ${axis.position.toFixed(3)}`), view.refusal].filter(Boolean).join(', ');
    this.onView(view);
    if (!this.held) return;
    if (view.answered_press === this.press && view.answer !== 'accepted') {
      this.report(this.held, view.message || text.arrived);
      return this.letGo();
    }
    // The first one may be of half a second ago.
    if (++this.fresh < 3) return this.message({ kind: '' }, view.number);
    this.order ??= this.held.order(view);
    this.message(this.order, view.number);
  }

  /** The console refuses: somebody else is in charge, for example. */
  refuse(message: string) {
    if (!this.held) return;
    this.report(this.held, message);
    this.letGo();
  }

  update(machines: Dict[]) {
    const names = machines.map((machine) => machine.cell as string);
    const shown = [...this.machines.options].map((option) => option.value);
    if (names.join() === shown.join()) return;
    this.letGo();
    this.machines.replaceChildren(...names.map((name) => {
      return option(name, name);
    }));
    this.onMachine();
  }
}
