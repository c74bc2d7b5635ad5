// What a person chooses of the picture of the block: a section, the colours, and how far along
// the order the cracks are shown.
import { Colour, Mode, css, first, last, modes, ofChannel, ofOutcome } from './colours';
import { Dict, labelled, make } from './dom';
import { fill, language, text } from './text';

const steps = 1000;      // of a slider
const playMs = 50;       // from one picture to the next
const playSteps = 5;     // in each: the whole takes ten seconds

export class GlassTools {
  readonly element = make('div', '', 'glass-tools');
  private colour = choice([text.byOutcome, text.byOrder, text.byTick, text.byChannel]);
  private legend = make('ul', '', 'legend');
  private axis = choice([text.noSection, 'x', 'y', 'z']);
  private cut = slider(steps / 2);
  private until = slider(steps);
  private play = make('button', text.play);
  private point = make('output', '', 'quiet');
  private playing: ReturnType<typeof setInterval> | undefined;
  private planned = 0;

  /** `onLook`: takes what view.ts calls a look. */
  constructor(private onLook: (look: Dict) => void) {
    const cutLabel = labelled(text.sectionAt, this.cut);
    cutLabel.hidden = true;
    this.axis.addEventListener('change', () => (cutLabel.hidden = this.axis.selectedIndex === 0));
    for (const control of [this.colour, this.axis, this.cut, this.until])
      control.addEventListener('input', () => this.changed());
    this.until.addEventListener('pointerdown', () => this.halt());
    this.play.addEventListener('click', () => (this.playing ? this.halt() : this.begin()));
    this.element.append(labelled(text.colours, this.colour), labelled(text.section, this.axis),
      cutLabel, labelled(text.madeUpTo, this.until), this.play, this.point,
      this.legend);
    this.showLegend();
  }

  private get mode(): Mode {
    return modes[this.colour.selectedIndex];
  }

  private showLegend() {
    const ways: [string, Colour][] = [[text.firstPoint, first], [text.lastPoint, last]];
    const outcomes = [text.planned, text.made, text.missed, text.skipped, text.uncertain,
      text.leftOut];
    const rows: Record<Mode, [string, Colour][]> = {
      outcome: outcomes.map((name, outcome) => [name, ofOutcome[outcome]]), order: ways, tick: ways,
      channel: ofChannel.map((colour, i) => [`${text.channel} ${i + 1}`, colour]),
    };
    this.legend.setAttribute('aria-label', text.colours);
    this.legend.replaceChildren(...rows[this.mode].map(([name, colour]) => {
      const row = make('li');
      const swatch = make('span', '', 'swatch');
      swatch.style.background = css(colour);
      row.append(swatch, name);
      return row;
    }));
  }

  /** The job has so many points. */
  follow(planned: number) {
    if (planned === this.planned) return;
    this.planned = planned;
    this.showPoint();
  }

  /** Another job is shown: all that was made of it. */
  restart() {
    this.halt();
    this.until.value = String(steps);
    this.changed();
  }

  private begin() {
    if (Number(this.until.value) >= steps) this.until.value = '0';
    this.play.textContent = text.pausePlay;
    this.playing = setInterval(() => {
      this.until.value = String(Number(this.until.value) + playSteps);
      this.changed();
      if (Number(this.until.value) >= steps) this.halt();
    }, playMs);
  }

  private halt() {
    clearInterval(this.playing);
    this.playing = undefined;
    this.play.textContent = text.play;
  }

  private showPoint() {
    const point = Math.round(this.planned * Number(this.until.value) / steps);
    this.point.textContent = this.planned ? fill(text.upToPoint, {
      point: point.toLocaleString(language), planned: this.planned.toLocaleString(language),
    }) : '';
  }

  private changed() {
    this.showPoint();
    this.showLegend();
    const cut = [1, 1, 1];
    const axis = this.axis.selectedIndex - 1;
    if (axis >= 0) cut[axis] = Number(this.cut.value) / steps;
    this.onLook({
      mode: this.mode, cut, until: Number(this.until.value) / steps,
    });
  }
}

function choice(names: string[]): HTMLSelectElement {
  const list = document.createElement('select');
  list.append(...names.map((name) => make('option', name)));
  return list;
}

function slider(value: number): HTMLInputElement {
  const range = document.createElement('input');
  range.type = 'range';
  range.max = String(steps);
  range.value = String(value);
  return range;
}
