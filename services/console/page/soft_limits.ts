// The soft limits of a machine, to be seen and set: a place of each axis, from and to.
import { Dict, labelled, make } from './dom';
import { Order } from './jog';
import { fill, text } from './text';

const names = ['x', 'y', 'z'];

export class SoftLimits {
  readonly element = make('fieldset');
  private lowest = names.map(() => place());
  private highest = names.map(() => place());
  private shown = '';  // the machine's limits that the fields have got

  constructor(buttons: HTMLElement) {
    this.element.append(make('legend', text.limits));
    names.forEach((axis, i) => {
      this.element.append(labelled(fill(text.limitFrom, { axis }), this.lowest[i]),
        labelled(fill(text.limitTo, { axis }), this.highest[i]));
    });
    this.element.append(buttons);
  }

  /** What somebody types stays until the limits of the machine change. */
  follow(view: Dict) {
    const axes: Dict[] = view.axes ?? [];
    const shown = JSON.stringify([view.cell, axes.map((axis) => [axis.min, axis.max])]);
    if (axes.length < 3 || shown === this.shown) return;
    this.shown = shown;
    axes.slice(0, 3).forEach((axis, i) => {
      this.lowest[i].value = String(Number(axis.min.toFixed(4)));
      this.highest[i].value = String(Number(axis.max.toFixed(4)));
    });
  }

  /** Why they cannot be saved; "": they can. */
  get missing(): string {
    return [...this.lowest, ...this.highest].some((field) => field.value === '')
      ? text.giveLimits : '';
  }

  get order(): Order {
    const [x, y, z] = this.lowest.map((field) => Number(field.value));
    const [x_max, y_max, z_max] = this.highest.map((field) => Number(field.value));
    return { kind: 'save_limits', x, y, z, x_max, y_max, z_max };
  }
}

function place(): HTMLInputElement {
  const input = document.createElement('input');
  Object.assign(input, { type: 'number', step: 'any' });
  return input;
}
