// A machine moved by hand, by buttons that are held. While a finger is down, the page answers
// each state of the machine with one message; nothing else sends one. So it ends when the finger
// lifts, the page is hidden, the connection stalls, or somebody else takes over.
import { Dict, make } from './dom';
import { fill, text } from './text';

interface Order {
  kind: string;
  x?: number;
  y?: number;
  z?: number;
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
  private held: ((view: Dict) => Order) | undefined;
  private order: Order | undefined;  // of the press, once the machine's state is known
  private fresh = 0;  // states since the press
  send: (message: Dict) => void = () => {};

  connectedCallback() {
    this.speed.type = 'number';
    Object.assign(this.speed, { min: '0.1', max: '100', step: 'any', value: '10' });
    for (const [value, label] of [['0', text.whileHeld], ['0.01', '0.01'], ['0.1', '0.1'],
      ['1', '1'], ['10', '10']]) {
      const option = document.createElement('option');
      option.value = value;
      option.textContent = label;
      this.step.append(option);
    }
    const line = (label: string, field: HTMLElement) => {
      const element = make('label', label);
      element.append(' ', field);
      return element;
    };
    this.machines.addEventListener('change', () => this.letGo());
    this.answer.setAttribute('role', 'status');
    this.append(make('p', text.jogHint, 'quiet'), line(text.machine, this.machines),
      line(text.step, this.step), line(text.speedMmS, this.speed), this.place, this.buttons,
      this.answer);
    this.showAxes(['x', 'y', 'z']);
  }

  /** A button that moves while it is held. */
  private button(label: string, order: (view: Dict) => Order) {
    const button = make('button', label, 'hold') as HTMLButtonElement;
    button.addEventListener('pointerdown', (event) => {
      if (event.isPrimary && event.button === 0) this.hold(order);
    });
    for (const end of ['pointerup', 'pointercancel', 'pointerleave', 'lostpointercapture',
      'keyup', 'blur'])
      button.addEventListener(end, () => this.letGo());
    button.addEventListener('contextmenu', (event) => event.preventDefault());
    button.addEventListener('keydown', (event) => {
      if (!event.repeat && (event.key === 'Enter' || event.key === ' ')) this.hold(order);
    });
    this.buttons.append(button);
  }

  private showAxes(names: string[]) {
    if (this.axes === names.join()) return;
    this.axes = names.join();
    this.buttons.replaceChildren();
    names.forEach((name, axis) => {
      for (const sign of [-1, 1])
        this.button(`${name} ${sign < 0 ? '−' : '+'}`, (view) => this.along(view, axis, sign));
    });
    this.button(text.home, () => ({ kind: 'home' }));
    this.button(text.zero, () => ({ kind: 'zero' }));
  }

  private along(view: Dict, axis: number, sign: number): Order {
    const step = Number(this.step.value);
    const values = view.axes.map((one: Dict, i: number) =>
      step ? one.position + (i === axis ? sign * step : 0) : i === axis ? sign : 0);
    const [x = 0, y = 0, z = 0] = values;
    return { kind: step ? 'move' : 'jog', x, y, z };
  }

  private hold(order: (view: Dict) => Order) {
    this.letGo();
    this.answer.textContent = '';
    ++this.press;
    this.held = order;
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
        cell: this.machines.value, press: this.press, seen, channel: 1,
        speed_mm_s: Number(this.speed.value) || 0, ...order,
      },
    });
  }

  /** A state of the machine: the only thing that is answered by a sample. */
  take(view: Dict) {
    if (view.cell !== this.machines.value) return;
    this.view = view;
    this.showAxes(view.axes.map((axis: Dict) => axis.name));
    this.place.textContent = [...view.axes.map((axis: Dict) =>
      `${axis.name} ${axis.position.toFixed(3)}`), view.refusal].filter(Boolean).join(', ');
    if (!this.held) return;
    if (view.answered_press === this.press && view.answer !== 'accepted') {
      this.answer.textContent = view.message || text.arrived;
      return this.letGo();
    }
    // The first one may be of half a second ago.
    if (++this.fresh < 3) return this.message({ kind: '' }, view.number);
    this.order ??= this.held(view);
    this.message(this.order, view.number);
  }

  /** The console refuses: somebody else is in charge, for example. */
  refuse(message: string) {
    if (!this.held) return;
    this.letGo();
    this.answer.textContent = message;
  }

  update(machines: Dict[]) {
    const names = machines.map((machine) => machine.cell as string);
    const shown = [...this.machines.options].map((option) => option.value);
    if (names.join() === shown.join()) return;
    this.letGo();
    this.machines.replaceChildren(...names.map((name) => {
      const option = document.createElement('option');
      option.value = option.textContent = name;
      return option;
    }));
  }
}
