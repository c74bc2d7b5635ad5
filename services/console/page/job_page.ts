// A new job: what is made in glass or of a board, on which machine, in which glass, and where in
// its block; points and time are shown as they change. The job file that it makes is one that the
// command line takes unchanged. Nothing is armed here.
import { BoardFields, boardFiles } from './board_fields';
import { Card, ChoiceCards } from './choice_cards';
import { Dict, get, make, post } from './dom';
import { drawGlass, drawKind, drawMachine } from './job_pictures';
import { ModelList } from './model_list';
import { Place, PlaceView } from './place_view';
import { fill, fillCounted, text } from './text';
import { sendFile } from './upload';

const previewDelayMs = 800;
const bridgeDelayMs = 3000;  // until the console knows the profile of a machine that has come
const usualGlass = 'N-BK7', usualMachine = 'els-03';

function place(vector: Dict | undefined): Place {
  return [vector?.x ?? 0, vector?.y ?? 0, vector?.z ?? 0];
}

export class JobPage extends HTMLElement {
  private fields: Record<string, HTMLInputElement> = {};
  private kind = new ChoiceCards(text.jobKind, () => this.kindChanged());
  private machine = new ChoiceCards(text.machine, () => this.changed());
  private glass = new ChoiceCards(text.jobGlass, () => this.changed());
  private models: ModelList = new ModelList(() => this.changed(), (model) => this.choose(model),
    (model, by) => this.places.move(model, by));
  private places: PlaceView = new PlaceView((model, by) => this.models.moved(model, by),
    () => this.changed(), (model) => this.choose(model));
  private board = new BoardFields(() => this.changed());
  private inGlass = make('div');
  private choices: Dict = {};
  private cells?: string;
  private progress = document.createElement('progress');
  private figures = make('div', '', 'quiet');
  private answer = make('div', '', 'need');
  private picture = document.createElement('img');
  private submission = '';
  private sentFiles: File[] = [];  // of the submission
  private timer = 0;
  private changes = 0;

  connectedCallback() {
    this.append(this.dropZone());
    this.kind.show(['glass', 'board'].map((kind): Card => ({
      value: kind, name: text[`kind_${kind}` as keyof typeof text], draw: drawKind(kind),
    })), 'glass');
    this.append(this.kind.element, this.models.element, this.places.element);
    for (const axis of ['x', 'y', 'z'])
      this.inGlass.append(this.field(axis, fill(text.blockSize, { axis }), 'number',
        axis === 'z' ? '30' : '50'));
    this.inGlass.append(this.field('spacing', text.spacing, 'number', '0.1'), this.glass.element);
    this.append(this.inGlass, this.board.element, this.machine.element,
      this.field('name', text.jobName, 'text', ''));
    const save = make('button', text.saveJob);
    save.addEventListener('click', () => this.save());
    const submit = make('button', text.submitJob);
    submit.addEventListener('click', () => this.submit());
    this.picture.alt = text.previewPicture;
    this.picture.hidden = this.progress.hidden = true;
    this.figures.setAttribute('role', 'status');
    this.answer.setAttribute('role', 'alert');
    this.progress.setAttribute('aria-label', text.sending);
    this.append(save, submit, this.progress, this.figures, this.answer, this.picture);
    this.showKind();
  }

  /** The machines of the shop, at each of its states while somebody is logged in. */
  follow(machines: Dict[]) {
    const cells = machines.map((machine) => machine.cell).sort().join();
    if (cells === this.cells) return;
    this.cells = cells;
    this.readChoices();
    setTimeout(() => this.readChoices(), bridgeDelayMs);
  }

  private async readChoices() {
    const choices = await get('choices');
    // A card that has the focus stays while nothing changes.
    if (!choices?.machines || JSON.stringify(choices) === JSON.stringify(this.choices)) return;
    this.choices = choices;
    this.glass.show((choices.glasses ?? []).map((glass: Dict): Card => ({
      value: glass.name, name: glass.name, draw: drawGlass(glass),
      figures: glass.index ? `n ${glass.index.toFixed(4)}` : '',
    })), this.glass.value || usualGlass);
    this.showMachines();
  }

  private showMachines() {
    const wanted = this.isBoard() ? 'courses' : 'points';
    const machines: Dict[] =
      (this.choices.machines ?? []).filter((machine: Dict) => machine.makes === wanted);
    const inShop = machines.find((machine) => machine.cells?.length);
    this.machine.show(machines.map((machine): Card => ({
      value: machine.machine_file, name: machine.name, draw: drawMachine(machine),
      figures: machine.cells?.length ? fill(text.inShop, { cells: machine.cells.join(', ') })
        : ['x', 'y', 'z'].map((axis) => machine.travel_mm?.[axis]?.toFixed(0) ?? '0').join(' x ') +
          ' mm',
    })), this.machine.value || inShop?.machine_file || usualMachine);
  }

  private isBoard(): boolean {
    return this.kind.value === 'board';
  }

  private kindChanged() {
    this.showKind();
    this.showMachines();
    this.changed();
  }

  private showKind() {
    this.inGlass.hidden = this.isBoard();
    this.board.element.hidden = !this.isBoard();
    this.models.showPlaces(!this.isBoard());
    if (this.isBoard()) this.places.element.hidden = true;
  }

  private dropZone(): HTMLElement {
    const drop = make('label', text.dropFiles, 'drop');
    const choose = document.createElement('input');
    choose.type = 'file';
    choose.multiple = true;
    choose.addEventListener('change', () => {
      this.add([...(choose.files ?? [])]);
      choose.value = '';
    });
    drop.append(choose);
    drop.addEventListener('dragover', (event) => event.preventDefault());
    drop.addEventListener('drop', (event) => {
      event.preventDefault();
      this.add([...(event.dataTransfer?.files ?? [])]);
    });
    return drop;
  }

  private field(name: string, label: string, type: string, value: string): HTMLElement {
    const line = make('label', label);
    const input = document.createElement('input');
    Object.assign(input, { type, value, step: 'any', min: type === 'number' ? '0' : '' });
    input.addEventListener('input', () => this.changed());
    this.fields[name] = input;
    line.append(' ', input);
    return line;
  }

  private add(files: File[]) {
    const first = this.models.models.length === 0;
    for (const file of files) this.models.addFile(file);
    if (first && files.some((file) => boardFiles.test(file.name)) && !this.isBoard()) {
      this.kind.choose('board');
      this.kindChanged();
    }
  }

  private choose(model: number) {
    this.models.choose(model);
    this.places.choose(model);
  }

  /** A job file, as JSON. */
  private job(): Dict {
    const number = (name: string) => Number(this.fields[name].value) || 0;
    const head: Dict = this.fields.name.value ? { name: this.fields.name.value } : {};
    if (this.machine.value) head.machine_file = this.machine.value;
    if (this.isBoard()) return { ...head, course: this.board.course(this.models.files()) };
    return {
      ...head,
      models: this.models.jobModels(),
      block: { size_mm: { x: number('x'), y: number('y'), z: number('z') } },
      glass: this.glass.value || usualGlass,
      discretization: { min_spacing_mm: number('spacing') },
    };
  }

  private isEmpty(): boolean {
    return this.isBoard() ? !this.models.files().length : !this.models.jobModels().length;
  }

  private changed() {
    const change = ++this.changes;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.preview(change), previewDelayMs);
  }

  /** Files of a submission never change: others are those of another one. */
  private nameSubmission() {
    const files = this.models.files();
    if (files.some((file) => !this.sentFiles.includes(file) &&
        this.sentFiles.some((sent) => sent.name === file.name))) {
      this.submission = '';
    }
    if (!this.submission) this.sentFiles = [];
    this.submission ||= `page-${Array.from(crypto.getRandomValues(new Uint8Array(8)),
      (byte) => byte.toString(16).padStart(2, '0')).join('')}`;
  }

  /** False: it was refused, which is shown. */
  private async send(change: number): Promise<boolean> {
    this.nameSubmission();
    for (const file of this.models.files()) {
      if (this.sentFiles.includes(file)) continue;
      this.progress.hidden = false;
      const refusal = await sendFile(this.submission, file, (sent) => {
        this.progress.max = file.size || 1;
        this.progress.value = sent;
      });
      this.progress.hidden = true;
      if (change !== this.changes) return false;
      this.answer.textContent = refusal;
      if (refusal) return false;
      this.sentFiles.push(file);
    }
    return true;
  }

  private async preview(change: number) {
    if (this.isEmpty()) return this.forget();
    this.figures.textContent = text.computing;
    if (!await this.send(change)) return;
    const answer = await post(`submissions/${this.submission}/preview`, this.job());
    if (change !== this.changes) return;
    this.figures.textContent = '';
    this.answer.textContent = answer?.time ? '' : answer?.message ?? text.lost;
    this.picture.hidden = !answer?.time;
    if (answer?.time) this.showPreview(answer);
  }

  private forget() {
    this.picture.hidden = true;
    this.figures.textContent = this.answer.textContent = '';
    this.places.show([], [0, 0, 0], 0, 0);
  }

  private showPreview(preview: Dict) {
    const minutes = ((preview.time.machining_time_s ?? 0) / 60).toFixed(1);
    const points = Number(preview.point_count ?? 0);
    const contours = Number(preview.course?.contour_count);
    this.figures.textContent = [
      preview.course
        ? fillCounted(text.courseFigures, contours,
            { contours, holes: Number(preview.course.hole_count ?? 0), minutes })
        : fillCounted(text.previewFigures, points, { points, minutes }),
      ...(preview.warnings ?? []).map((warning: Dict) => warning.text),
    ].join('; ');
    this.picture.src = `/api/v1/submissions/${this.submission}/preview?at=${Date.now()}`;
    if (this.isBoard()) return;
    this.places.show(
      (preview.models ?? []).map((model: Dict) =>
        ({ name: model.name, low: place(model.low_mm), size: place(model.size_mm) })),
      place(preview.block_size_mm), preview.margin_mm ?? 0, this.models.chosen);
  }

  private save() {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(
      new Blob([JSON.stringify(this.job(), null, 2) + '\n'], { type: 'application/json' }));
    link.download = `${this.fields.name.value || 'job'}.json`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  private async submit() {
    const change = ++this.changes;
    clearTimeout(this.timer);
    if (!await this.send(change)) return;
    const answer = await post(`submissions/${this.submission}`, this.job());
    this.answer.textContent = answer?.submitted ? '' : answer?.message ?? text.lost;
    if (!answer?.submitted) return;
    this.figures.textContent = fill(text.submitted, { job: answer.job });
    this.submission = '';  // the next press submits another one
  }
}
