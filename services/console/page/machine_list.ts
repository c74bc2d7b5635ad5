// The machines of the shop, with what holds them; an operator releases the stops that are shown.
import { Dict, askTwice, make, post } from './dom';
import { machineState } from './machine_state';
import { fill, text } from './text';

/** It stays the same element while its machine is there. */
class MachineLine {
  readonly element = make('li');
  private state = make('div');
  private place = make('div', '', 'quiet');
  private held = make('div');
  private answer = make('div', '', 'need');
  private presses: string[] = [];
  // When the button was first pressed; none: the stop that the machine itself keeps latched.
  private shown: string[] = [];

  constructor(private cell: string) {
    const reset = make('button', text.reset);
    reset.dataset.command = 'reset';
    askTwice(reset, fill(text.resetSure, { cell }), () => this.reset(),
      () => (this.shown = this.presses));
    this.held.append(reset);
    this.answer.setAttribute('role', 'status');
    this.element.append(make('div', cell), this.state, this.place, this.held, this.answer);
  }

  /** A press that came after it was read stays. */
  private async reset() {
    const answer = await post(`machines/${encodeURIComponent(this.cell)}/reset`,
      { presses: this.shown });
    this.answer.textContent = answer ? answer.message ?? '' : text.lost;
  }

  update(machine: Dict, stage: Dict | undefined) {
    this.presses = machine.stops_held ?? [];
    this.held.hidden = !this.presses.length &&
      (!machine.laser_line_up || machine.stop_released);
    const place = stage
      ? [stage.x_mm, stage.y_mm, stage.z_mm].map((mm: number) => mm.toFixed(2)).join(' ')
      : '-';
    this.state.textContent = machineState(machine);
    this.place.textContent = fill(text.stagePlace, { place, block: machine.mounted || '-' });
  }
}

export class MachineList extends HTMLElement {
  private lines = new Map<string, MachineLine>();
  private list = make('ul');
  private empty = make('li', text.noMachines, 'quiet');

  connectedCallback() {
    this.append(this.list);
  }

  update(machines: Dict[], stages: Dict[]) {
    const there = new Set<string>(machines.map((machine) => machine.cell));
    for (const [cell, line] of this.lines) {
      if (there.has(cell)) continue;
      line.element.remove();
      this.lines.delete(cell);
    }
    for (const machine of machines) {
      let line = this.lines.get(machine.cell);
      if (!line) {
        line = new MachineLine(machine.cell);
        this.lines.set(machine.cell, line);
        this.list.append(line.element);
      }
      line.update(machine, stages.find((stage) => stage.cell === machine.cell));
    }
    if (machines.length) this.empty.remove();
    else this.list.append(this.empty);
  }
}
