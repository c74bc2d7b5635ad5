// What is taught at the machine that is moved by hand: zeros, positions, lamp and shutters. Each
// order is one of a button that is held (jog.ts), so none is sent by a reload or a touch that
// slips; the motion bridge decides.
import { Dict, labelled, make } from './dom';
import { JogPanel, Order } from './jog';
import { SoftLimits } from './soft_limits';
import { TestJobs } from './test_jobs';
import { fill, language, text } from './text';

export class TeachPanel extends HTMLElement {
  private hand!: JogPanel;
  private profile = make('p', '', 'quiet');
  private lens = document.createElement('select');
  private channel = document.createElement('select');
  private height = number('any');
  private axes = ['x', 'y', 'z'].map(() => checkbox());
  private zero = make('div', '', 'zero');
  private last = make('div', '', 'quiet');
  private light = make('div', '', 'need');
  private answer = make('div', '', 'need');
  private ofProfile: HTMLElement[] = [];  // what a machine without one does not have
  private limits!: SoftLimits;
  private tests!: TestJobs;
  private teaching: Dict = {};
  private shown = '';  // machine and number of what was taught that are shown

  attach(hand: JogPanel) {
    this.hand = hand;
    hand.onMachine = () => {
      this.shown = '';
      this.load();
    };
    hand.onView = (view) => this.follow(view);
    const lens = labelled(text.lens, this.lens);
    const channel = labelled(text.channel, this.channel);
    for (const list of [this.lens, this.channel])
      list.addEventListener('change', () => this.showZero());
    const axes = make('fieldset');
    axes.append(make('legend', text.zeroAxes),
      ...this.axes.map((box, axis) => labelled('xyz'[axis], box)));
    const zero = () => ({ z: this.heightMm, channel: this.channelNumber, lens: this.lens.value });
    const needsHeight = () => (this.height.value === '' ? text.giveHeight : '');
    const needsAxes = () => (this.sets ? needsHeight() : text.giveAxes);
    const zeros = this.buttons(
      this.button(text.zero, () => ({ kind: 'zero', ...zero() }), needsHeight),
      this.button(text.saveZero, () => ({ kind: 'save_zero', ...zero(), sets: this.sets }),
        needsAxes),
      this.button(text.undo, () => ({ kind: 'undo' })));
    const places = this.buttons(
      this.button(text.saveSample, () => ({ kind: 'save_sample' })),
      this.button(text.savePark, () => ({ kind: 'save_park' })));
    this.limits = new SoftLimits(this.buttons(
      this.button(text.saveLimits, () => this.limits.order, () => this.limits.missing),
      this.button(text.forgetLimits, () => ({ kind: 'forget_limits' }))));
    const lights = this.buttons(
      this.button(text.lampOn, () => ({ kind: 'lamp' })),
      this.button(text.shutterOpen, () => ({ kind: 'shutter', channel: this.channelNumber })));
    this.tests = new TestJobs(hand, () =>
      ({ lens: this.lens.value, channel: this.channelNumber }));
    this.ofProfile = [lens, channel, this.zero, this.last, places, this.limits.element,
      lights, this.tests.element];
    this.answer.setAttribute('role', 'status');
    this.append(make('p', text.teachHint, 'quiet'), this.profile, lens, channel, this.zero,
      labelled(text.heightMm, this.height), axes, zeros, this.last, places, this.limits.element,
      lights, this.light, this.answer, this.tests.element);
    this.show();
  }

  /** The jobs of the shop: those that are focus series can be read. */
  update(jobs: Dict[]) {
    this.tests.update(jobs);
  }

  private button(label: string, order: (view: Dict) => Order, why?: () => string) {
    return this.hand.button(label,
      { order, why, report: (line) => (this.answer.textContent = line) });
  }

  private buttons(...buttons: HTMLElement[]): HTMLElement {
    const group = make('div', '', 'jog');
    group.append(...buttons);
    return group;
  }

  private get heightMm(): number {
    return Number(this.height.value) || 0;
  }

  private get channelNumber(): number {
    return Number(this.channel.value) || 1;
  }

  private get sets(): number {
    return this.axes.reduce((sum, box, axis) => sum + (box.checked ? 1 << axis : 0), 0);
  }

  /** A state of the machine: somebody may have taught it, here or elsewhere. */
  private follow(view: Dict) {
    const shutters: number[] = view.shutters_by_hand ?? [];
    this.light.textContent = [view.lamp_by_hand ? text.lampByHand : '',
      shutters.length ? fill(text.shutterByHand, { channels: shutters.join(', ') }) : '']
      .filter(Boolean).join(', ');
    this.limits.follow(view);
    const shown = `${view.cell} ${view.taught_number}`;
    if (shown === this.shown) return;
    this.shown = shown;
    this.tests.forget();
    this.load();
  }

  private async load() {
    const cell = this.hand.machine;
    if (!cell) return;
    try {
      const response = await fetch(`/api/v1/machines/${encodeURIComponent(cell)}/teaching`);
      const answer = await response.json();
      if (cell !== this.hand.machine) return;
      this.teaching = response.ok ? answer : { message: answer.message };
      this.shown ||= `${cell} ${answer.taught_number ?? 0}`;
    } catch {
      return;  // the next change asks again
    }
    this.show();
  }

  private show() {
    const { lenses = [], channels = 0, mounted_lens } = this.teaching;
    for (const element of this.ofProfile) element.hidden = !channels;
    this.profile.textContent = this.teaching.message ?? this.teaching.profile ?? '';
    fillList(this.lens, lenses.map((lens: Dict) => lens.name), mounted_lens ?? '');
    fillList(this.channel, Array.from({ length: channels }, (_, i) => String(i + 1)), '1');
    const when = this.teaching.taught_utc
      ? new Date(this.teaching.taught_utc).toLocaleString(language) : '';
    this.last.textContent = this.teaching.taught_number
      ? fill(text.taughtLast, { change: this.teaching.taught_change,
        by: this.teaching.taught_by, time: when })
      : text.taughtNothing;
    this.showZero();
  }

  private showZero() {
    const zero = (this.teaching.zeros ?? []).find((one: Dict) =>
      one.lens === this.lens.value && one.channel === this.channelNumber);
    this.zero.textContent = zero ? fill(zero.taught ? text.zeroTaught : text.zeroOfProfile, {
      x: zero.x_mm.toFixed(3), y: zero.y_mm.toFixed(3), z: zero.z_mm.toFixed(3),
    }) : '';
  }
}

/** A list keeps what is chosen while it is among the names. */
function fillList(list: HTMLSelectElement, names: string[], usual: string) {
  if ([...list.options].map((option) => option.value).join() === names.join()) return;
  const chosen = names.includes(list.value) ? list.value : usual;
  list.replaceChildren(...names.map((name) => {
    const option = make('option', name) as HTMLOptionElement;
    option.value = name;
    option.selected = name === chosen;
    return option;
  }));
}

function number(step: string): HTMLInputElement {
  const input = document.createElement('input');
  Object.assign(input, { type: 'number', min: '0', step });
  return input;
}

function checkbox(): HTMLInputElement {
  const input = document.createElement('input');
  Object.assign(input, { type: 'checkbox', checked: true });
  return input;
}
