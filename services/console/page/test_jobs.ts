// Test pulses and focus series at the machine that is moved by hand: jobs, which fire when they
// are armed as any other. The first visible crack of a series moves the zero, by a button that is
// held.
import { Dict, make, post } from './dom';
import { JogPanel } from './jog';
import { fill, text } from './text';

/** What is chosen beside it. */
export interface Place {
  lens: string;
  channel: number;
}

export class TestJobs {
  readonly element = make('div');
  private fields: Record<string, HTMLInputElement> = {};
  private series = document.createElement('select');
  private move: Dict | undefined;
  private moveLine = make('div', '', 'quiet');
  private answer = make('div', '', 'need');
  private asked = 0;  // number of the newest question

  constructor(private hand: JogPanel, private place: () => Place) {
    const block = this.group(text.testBlock);
    for (const axis of ['x', 'y', 'z'])
      block.append(this.field(`block_${axis}_mm`, fill(text.blockSize, { axis }), ''));
    const glass = this.field('glass', text.jobGlass, 'N-BK7', 'text');
    const energy = this.field('energy_mj', text.energyMj, '');
    const series = this.group(text.focusSeries);
    series.append(this.field('step_mm', text.depthStep, '0.05'),
      this.field('count', text.pointCount, '20'), this.field('pitch_mm', text.pitch, '0.5'));
    const submit = make('div', '', 'jog');
    submit.append(this.button(text.submitPulse, 'pulse'), this.button(text.submitSeries, 'focus'));
    const move = this.group(text.firstCrack);
    const list = make('label', `${text.series} `);
    list.append(this.series);
    const first = this.field('first', text.firstVisible, '');
    for (const control of [this.series, this.fields.first])
      control.addEventListener('input', () => this.ask());
    const held = make('div', '', 'jog');
    held.append(hand.button(text.moveZero, {
      order: () => ({
        kind: 'move_zero', z: this.move!.z_mm, lens: this.move!.lens,
        channel: this.move!.channel, sets: 4,
      }),
      why: () => (this.move ? '' : text.giveFirst),
      report: (line) => this.report(line),
    }));
    move.append(list, first, this.moveLine, held);
    this.answer.setAttribute('role', 'status');
    this.element.append(make('p', text.testHint, 'quiet'), block, glass, energy, series, submit,
      this.answer, move);
  }

  private group(name: string): HTMLElement {
    const group = make('fieldset');
    group.append(make('legend', name));
    return group;
  }

  private field(name: string, label: string, value: string, type = 'number'): HTMLElement {
    const line = make('label', `${label} `);
    const input = document.createElement('input');
    Object.assign(input, { type, value, step: 'any', min: type === 'number' ? '0' : '' });
    this.fields[name] = input;
    line.append(input);
    return line;
  }

  private report(line: string) {
    this.answer.textContent = line;
  }

  private button(label: string, kind: string): HTMLElement {
    const button = make('button', label) as HTMLButtonElement;
    button.addEventListener('click', async () => {
      button.disabled = true;  // one job for each press
      this.report(text.computing);
      await this.submit(kind);
      button.disabled = false;
    });
    return button;
  }

  private async submit(kind: string) {
    const number = (name: string) => Number(this.fields[name].value) || 0;
    const random = crypto.getRandomValues(new Uint32Array(2));
    const body: Dict = {
      id: `${kind}-${[...random].map((part) => part.toString(16)).join('')}`,
      glass: this.fields.glass.value, ...this.place(),
    };
    for (const name of ['block_x_mm', 'block_y_mm', 'block_z_mm', 'energy_mj', 'step_mm', 'count',
      'pitch_mm'])
      body[name] = number(name);
    const answer = await post(`machines/${encodeURIComponent(this.hand.machine)}/${kind}`, body);
    this.report(answer?.submitted ? fill(text.submittedToArm, { job: answer.job })
      : answer?.message ?? text.lost);
  }

  /** How the zero would move; nothing moves by it. */
  private async ask() {
    const asked = ++this.asked;
    this.move = undefined;
    this.moveLine.textContent = '';
    const first = this.fields.first.value;
    if (!first || !this.series.value) return;
    let answer: Dict;
    try {
      const response = await fetch(`/api/v1/machines/${encodeURIComponent(this.hand.machine)}` +
        `/zero_move?job=${this.series.value}&first=${encodeURIComponent(first)}`);
      answer = await response.json();
      if (asked !== this.asked) return;
      if (response.ok) this.move = answer;
    } catch {
      return;
    }
    this.moveLine.textContent = this.move
      ? fill(text.zeroMoves, { ...this.move, z: answer.z_mm.toFixed(3) } as Dict)
      : answer.message;
  }

  /** Another machine, or another zero: what was computed is not of it. */
  forget() {
    this.fields.first.value = '';
    this.ask();
  }

  /** The jobs that may be series of this machine, the newest first. */
  update(jobs: Dict[]) {
    const numbers = jobs.filter((job) => job.state === 'done' && job.name === 'focus series' &&
      job.cell === this.hand.machine).map((job) => String(job.job)).reverse();
    if ([...this.series.options].map((option) => option.value).join() === numbers.join()) return;
    const chosen = this.series.value;
    this.series.replaceChildren(...numbers.map((number) => {
      const option = make('option', number) as HTMLOptionElement;
      option.value = number;
      option.selected = number === chosen;
      return option;
    }));
    if (this.series.value !== chosen) this.forget();
  }
}
