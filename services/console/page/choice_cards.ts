// A choice by pictures: a group of radio buttons, each a card with a picture, a name and figures.
import { make } from './dom';

export interface Card {
  value: string;
  name: string;
  figures?: string;
  /** Draws on a canvas of pictureWidth x pictureHeight. */
  draw: (picture: CanvasRenderingContext2D) => void;
}
export const pictureWidth = 96;
export const pictureHeight = 72;

let groups = 0;

export class ChoiceCards {
  readonly element = make('fieldset', '', 'cards');
  private group = `cards-${++groups}`;
  private chosen = '';

  constructor(private legend: string, private onChange: () => void) {}

  get value(): string {
    return this.chosen;
  }

  /** Chooses `value`; the first card where no card has it, and nothing without a card. */
  show(cards: Card[], value: string) {
    const known = cards.some((card) => card.value === value);
    this.chosen = known ? value : cards[0]?.value ?? '';
    this.element.hidden = !cards.length;
    this.element.replaceChildren(make('legend', this.legend),
      ...cards.map((card) => this.cardElement(card)));
  }

  choose(value: string) {
    this.chosen = value;
    for (const button of this.element.querySelectorAll('input'))
      button.checked = button.value === value;
  }

  private cardElement(card: Card): HTMLElement {
    const label = make('label');
    const button = document.createElement('input');
    Object.assign(button, {
      type: 'radio', name: this.group, value: card.value, checked: card.value === this.chosen,
    });
    button.addEventListener('change', () => {
      this.chosen = card.value;
      this.onChange();
    });
    const canvas = document.createElement('canvas');
    Object.assign(canvas, { width: pictureWidth, height: pictureHeight });
    canvas.setAttribute('aria-hidden', 'true');
    // Drawn once, without the graphics card, whose process keeps memory for each other canvas.
    card.draw(canvas.getContext('2d', { willReadFrequently: true })!);
    label.append(button, canvas, make('span', card.name));
    if (card.figures) label.append(make('span', card.figures, 'quiet'));
    return label;
  }
}
