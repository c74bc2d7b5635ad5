// The models of a new job: files and texts, with the size, the place, the turn and the method of
// the one that is chosen.
import { Card, ChoiceCards } from './choice_cards';
import { Dict, labelled, make, option } from './dom';
import { drawMethod } from './job_pictures';
import { Place } from './place_view';
import { fill, text } from './text';

/** For which endings a method makes points, and which axis is up where a model is not turned. */
const kinds: { ending: RegExp; methods: string[]; up: string }[] = [
  { ending: /\.(stl|obj|ply|3mf|3ds)$/i, methods: ['even', 'sections', 'fill', 'rays', 'solid'],
    up: 'UP_AXIS_Z' },
  { ending: /\.(glb|gltf)$/i, methods: ['even', 'sections', 'fill', 'rays', 'solid'],
    up: 'UP_AXIS_Y' },
  { ending: /\.dae$/i, methods: ['even', 'sections', 'fill', 'rays', 'solid'],
    up: 'UP_AXIS_DECLARED' },
  { ending: /\.(dxf|svg|plt|hpgl?|nci)$/i, methods: ['curves'], up: 'UP_AXIS_Y' },
  { ending: /\.(png|jpe?g|bmp|tiff?|pcx)$/i, methods: ['halftone', 'relief'], up: 'UP_AXIS_Y' },
];
const textKind = { methods: ['curves'], up: 'UP_AXIS_Y' };
const cloudKind = { methods: [] as string[], up: 'UP_AXIS_Z' };
const axes = ['x', 'y', 'z'] as const;
const ups = ['', 'Z', 'Y', 'X', 'MINUS_Z', 'MINUS_Y', 'MINUS_X'];

export interface Model {
  file?: File;     // else a text
  text: string;
  size: number;    // its largest extent, mm; 0: as in its file
  move: Place;     // mm, from the middle of the block
  turn: Place;     // deg, about x, y, z
  up: string;      // the axis of its file that is upright, of UpAxis; '': the usual one
  method: string;  // '': the usual one
}

function kindOf(model: Model) {
  if (!model.file) return textKind;
  return kinds.find((kind) => kind.ending.test(model.file!.name)) ?? cloudKind;
}

function vector(place: Place): Dict {
  return { x: place[0], y: place[1], z: place[2] };
}

const isZero = (place: Place) => place.every((value) => value === 0);

/** A member of Model of the job file. */
function jobModel(model: Model): Dict {
  const kind = kindOf(model);
  const placement: Dict = {
    ...(model.size > 0 ? { fit_size_mm: model.size } : {}),
    ...(isZero(model.move) ? {} : { move_mm: vector(model.move) }),
    // A model that is turned is turned from how it lies in its file, unless its axis is named.
    ...(isZero(model.turn) ? {} : { rotate_deg: vector(model.turn), up: kind.up }),
    ...(model.up ? { up: model.up } : {}),
  };
  return {
    ...(model.file ? { file: model.file.name }
                   : { text: { text: model.text, font: 'DejaVu Sans' } }),
    ...(Object.keys(placement).length ? { placement } : {}),
    ...(model.method ? { [model.method]: {} } : {}),
  };
}

export class ModelList {
  readonly element = make('div');
  readonly models: Model[] = [];
  private list = make('ul');
  private details = make('div');
  private placed = true;
  private inputs: Record<string, HTMLInputElement> = {};
  private up = document.createElement('select');
  private method: ChoiceCards;
  chosen = 0;

  /** `onChange`: what is made changes; `onMove`: a model was moved by numbers. */
  constructor(private onChange: () => void, private onChoose: (model: number) => void,
              private onMove: (model: number, by: Place) => void) {
    this.method = new ChoiceCards(text.method, () => {
      this.models[this.chosen].method = this.method.value;
      this.onChange();
    });
    this.up.append(...ups.map((up) => option(up && `UP_AXIS_${up}`,
      up.replace('MINUS_', '-').toLowerCase() || text.method_usual)));
    this.up.addEventListener('change', () => {
      this.models[this.chosen].up = this.up.value;
      this.onChange();
    });
    const group = (name: string, fields: HTMLElement[]) => {
      const element = make('fieldset');
      element.append(make('legend', name), ...fields);
      return element;
    };
    this.details.append(this.input('text', text.jobText, 'text'),
      this.input('size', text.modelSize, 'number'), labelled(text.upAxis, this.up),
      group(text.modelPlace, axes.map((axis) => this.input(`move-${axis}`, axis, 'number'))),
      group(text.modelTurn, axes.map((axis) => this.input(`turn-${axis}`, axis, 'number'))),
      this.method.element);
    this.inputs.size.min = '0';
    const addText = make('button', text.addText);
    addText.addEventListener('click', () => {
      this.add({ text: text.jobText });
      this.inputs.text.focus();
      this.inputs.text.select();
    });
    this.element.append(this.list, addText, this.details);
    this.show();
  }

  private input(name: string, label: string, type: string): HTMLElement {
    const line = make('label', `${label} `);
    const input = document.createElement('input');
    Object.assign(input, { type, step: 'any' });
    input.addEventListener('input', () => this.edited());
    this.inputs[name] = input;
    line.append(input);
    return line;
  }

  private add(model: Partial<Model>) {
    this.models.push({
      text: '', size: 20, move: [0, 0, 0], turn: [0, 0, 0], up: '', method: '', ...model,
    });
    this.chosen = this.models.length - 1;
    this.show();
    this.onChange();
  }

  /** A file of the same name takes the place of the one before. */
  addFile(file: File) {
    const before = this.models.find((model) => model.file?.name === file.name);
    if (!before) return this.add({ file });
    before.file = file;
    this.onChange();
  }

  /** False: the files of a board stay where they are in their common frame. */
  showPlaces(placed: boolean) {
    this.placed = placed;
    this.show();
  }

  choose(model: number) {
    this.chosen = model;
    this.show();
  }

  /** By the mouse. */
  moved(model: number, by: Place) {
    const place = this.models[model].move;
    this.models[model].move =
      place.map((mm, axis) => Number((mm + by[axis]).toFixed(3))) as Place;
    this.showNumbers();
  }

  files(): File[] {
    return this.models.flatMap((model) => (model.file ? [model.file] : []));
  }

  /** For a job file; a text without letters is left out. */
  jobModels(): Dict[] {
    return this.models.filter((model) => model.file || model.text).map(jobModel);
  }

  private edited() {
    const model = this.models[this.chosen];
    const number = (name: string) => Number(this.inputs[name].value) || 0;
    const before = model.move;
    model.text = this.inputs.text.value;
    model.size = number('size');
    model.move = axes.map((axis) => number(`move-${axis}`)) as Place;
    model.turn = axes.map((axis) => number(`turn-${axis}`)) as Place;
    const by = model.move.map((mm, axis) => mm - before[axis]) as Place;
    if (!isZero(by)) this.onMove(this.chosen, by);
    this.showList();
    this.onChange();
  }

  private showList() {
    this.list.replaceChildren(...this.models.map((model, number) => {
      const item = make('li');
      const name = model.file?.name ?? model.text;
      const choose = make('button', name);
      choose.setAttribute('aria-pressed', String(number === this.chosen));
      choose.addEventListener('click', () => this.onChoose(number));
      const remove = make('button', text.remove);
      remove.setAttribute('aria-label', fill(text.removeModel, { name }));
      remove.addEventListener('click', () => {
        this.models.splice(number, 1);
        this.chosen = Math.min(this.chosen, Math.max(0, this.models.length - 1));
        this.show();
        this.onChange();
      });
      item.append(choose, ' ', remove);
      return item;
    }));
  }

  private showNumbers() {
    const model = this.models[this.chosen];
    const values: Record<string, string | number> = { text: model.text, size: model.size || '' };
    axes.forEach((axis, number) => {
      values[`move-${axis}`] = model.move[number];
      values[`turn-${axis}`] = model.turn[number];
    });
    for (const [name, input] of Object.entries(this.inputs)) {
      if (document.activeElement !== input || input.type !== 'text')
        input.value = String(values[name]);
    }
  }

  private show() {
    this.showList();
    const model = this.models[this.chosen];
    this.details.hidden = !model || !this.placed;
    if (!model) return;
    this.inputs.text.parentElement!.hidden = !!model.file;
    this.showNumbers();
    this.up.value = model.up;
    const { methods } = kindOf(model);
    const names = methods.length ? ['', ...methods] : [];
    this.method.show(names.map((method): Card => ({
      value: method,
      name: text[`method_${method || 'usual'}` as keyof typeof text],
      draw: drawMethod(method, methods),
    })), model.method);
  }
}
