// A new job: files are dropped, glass and sizes chosen, points and time shown as they change; the
// job file that it makes is one that the command line takes unchanged. Nothing is armed here.
import { Dict, make, post } from './dom';
import { fill, fillCounted, text } from './text';
import { sendFile } from './upload';

// For which endings a method makes points; the first is the default of its kind.
const methods: [RegExp, string[]][] = [
  [/\.(stl|obj|ply|3mf|glb|gltf|dae|3ds)$/i, ['even', 'sections', 'fill', 'rays', 'solid']],
  [/\.(dxf|svg|plt|hpgl?)$/i, ['curves']],
  [/\.(png|jpe?g|bmp|pcx)$/i, ['halftone', 'relief']],
];
const previewDelayMs = 800;

export class JobPage extends HTMLElement {
  private files = new Map<string, File>();
  private fields: Record<string, HTMLInputElement> = {};
  private method = document.createElement('select');
  private list = make('ul');
  private progress = document.createElement('progress');
  private figures = make('div', '', 'quiet');
  private answer = make('div', '', 'need');
  private picture = document.createElement('img');
  private submission = '';
  private timer = 0;
  private changes = 0;

  connectedCallback() {
    const drop = make('label', text.dropFiles, 'drop');
    const choose = document.createElement('input');
    choose.type = 'file';
    choose.multiple = true;
    choose.addEventListener('change', () => this.add([...(choose.files ?? [])]));
    drop.append(choose);
    drop.addEventListener('dragover', (event) => event.preventDefault());
    drop.addEventListener('drop', (event) => {
      event.preventDefault();
      this.add([...(event.dataTransfer?.files ?? [])]);
    });
    this.append(drop, this.list);
    this.field('name', text.jobName, 'text', '');
    this.field('text', text.jobText, 'text', '');
    this.field('glass', text.jobGlass, 'text', 'N-BK7');
    for (const axis of ['x', 'y', 'z'])
      this.field(axis, fill(text.blockSize, { axis }), 'number', axis === 'z' ? '30' : '50');
    this.field('size', text.modelSize, 'number', '20');
    this.field('spacing', text.spacing, 'number', '0.1');
    this.field('machine', text.machineProfile, 'text', '');
    const line = make('label', text.method);
    line.append(' ', this.method);
    this.append(line);
    this.method.addEventListener('change', () => this.changed());
    this.showMethods();
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
  }

  private field(name: string, label: string, type: string, value: string) {
    const line = make('label', label);
    const input = document.createElement('input');
    Object.assign(input, { type, value, step: 'any', min: type === 'number' ? '0' : '' });
    input.addEventListener('input', () => this.changed());
    this.fields[name] = input;
    line.append(' ', input);
    this.append(line);
  }

  private showMethods() {
    const [file] = this.files.keys();
    const known = methods.find(([ending]) => ending.test(file ?? ''))?.[1] ?? [];
    this.method.replaceChildren(...['', ...known].map((name) => {
      const option = document.createElement('option');
      option.value = name;
      option.textContent = name || text.usual;
      return option;
    }));
  }

  private add(files: File[]) {
    for (const file of files) this.files.set(file.name, file);
    // Files of a submission never change: others are those of another one.
    this.submission = '';
    this.list.replaceChildren(...[...this.files.keys()].map((name) => {
      const item = make('li', name);
      const remove = make('button', text.remove);
      remove.addEventListener('click', () => {
        this.files.delete(name);
        this.add([]);
      });
      item.append(' ', remove);
      return item;
    }));
    this.showMethods();
    this.changed();
  }

  /** A job file, as JSON. */
  private job(): Dict {
    const number = (name: string) => Number(this.fields[name].value) || 0;
    const method = this.method.value ? { [this.method.value]: {} } : {};
    const placement = number('size') > 0 ? { placement: { fit_size_mm: number('size') } } : {};
    const models: Dict[] = [...this.files.keys()].map((file) => ({ file, ...placement, ...method }));
    if (this.fields.text.value)
      models.push({ text: { text: this.fields.text.value, font: 'DejaVu Sans' }, ...(models.length ? {} : placement) });
    return {
      ...(this.fields.name.value ? { name: this.fields.name.value } : {}),
      models,
      block: { size_mm: { x: number('x'), y: number('y'), z: number('z') } },
      glass: this.fields.glass.value,
      discretization: { min_spacing_mm: number('spacing') },
      ...(this.fields.machine.value ? { machine_file: this.fields.machine.value } : {}),
    };
  }

  private changed() {
    const change = ++this.changes;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.preview(change), previewDelayMs);
  }

  /** False: it was refused, which is shown. */
  private async send(change: number): Promise<boolean> {
    this.submission ||= `page-${Array.from(crypto.getRandomValues(new Uint8Array(8)),
      (byte) => byte.toString(16).padStart(2, '0')).join('')}`;
    for (const file of this.files.values()) {
      this.progress.hidden = false;
      const refusal = await sendFile(this.submission, file, (sent) => {
        this.progress.max = file.size || 1;
        this.progress.value = sent;
      });
      this.progress.hidden = true;
      if (change !== this.changes) return false;
      this.answer.textContent = refusal;
      if (refusal) return false;
    }
    return true;
  }

  private async preview(change: number) {
    if (!this.files.size && !this.fields.text.value) return;
    this.figures.textContent = text.computing;
    if (!await this.send(change)) return;
    const answer = await post(`submissions/${this.submission}/preview`, this.job());
    if (change !== this.changes) return;
    this.figures.textContent = '';
    this.answer.textContent = answer?.time ? '' : answer?.message ?? text.lost;
    this.picture.hidden = !answer?.time;
    if (!answer?.time) return;
    this.figures.textContent = [
      fillCounted(text.previewFigures, answer.point_count ?? 0, {
        points: answer.point_count ?? 0,
        minutes: ((answer.time.machining_time_s ?? 0) / 60).toFixed(1),
      }),
      ...(answer.warnings ?? []).map((warning: Dict) => warning.text),
    ].join('; ');
    this.picture.src = `/api/v1/submissions/${this.submission}/preview?at=${Date.now()}`;
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
