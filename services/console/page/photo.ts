// The photograph of the block of a job: a person takes or chooses it, the page makes it as small as
// a screen shows it, and the console keeps it in the folder of the job.
import { Dict, make } from './dom';
import { text } from './text';

const maxPx = 2048;
const quality = 0.85;

/** As a JPEG of at most so many pixels along a side; the file itself where the browser cannot
 * read it: the console then says why. */
async function smaller(file: File): Promise<Blob> {
  try {
    const picture = await createImageBitmap(file);
    const scale = Math.min(1, maxPx / Math.max(picture.width, picture.height));
    const canvas = document.createElement('canvas');
    canvas.width = Math.max(1, Math.round(picture.width * scale));
    canvas.height = Math.max(1, Math.round(picture.height * scale));
    canvas.getContext('2d')!.drawImage(picture, 0, 0, canvas.width, canvas.height);
    const made = await new Promise<Blob | null>((done) =>
      canvas.toBlob(done, 'image/jpeg', quality));
    return made ?? file;
  } catch {
    return file;
  }
}

/** Of one job, by its number or uid. */
export class PhotoPanel {
  readonly element = make('div', '', 'photo');
  private file = document.createElement('input');
  private picture = document.createElement('img');
  private url: string;

  constructor(job: number | string, private report: (line: string) => void) {
    this.url = `/api/v1/photos/${job}`;
    Object.assign(this.file, { type: 'file', accept: 'image/jpeg,image/png' });
    const add = make('label', `${text.addPhoto} `);
    add.dataset.command = 'photo';
    add.append(this.file);
    this.file.addEventListener('change', () => this.send());
    const show = make('button', text.showPhoto);
    show.addEventListener('click', () => this.show());
    this.picture.alt = text.blockPhoto;
    this.picture.hidden = true;
    this.picture.addEventListener('load', () => (this.picture.hidden = false));
    this.picture.addEventListener('error', () => this.report(text.noPhoto));
    this.element.append(show, add, this.picture);
  }

  private show() {
    this.picture.hidden = true;
    this.report('');
    this.picture.src = `${this.url}?at=${Date.now()}`;
  }

  private async send() {
    const file = this.file.files?.[0];
    if (!file) return;
    let answer: Dict | undefined;
    try {
      const response = await fetch(`${this.url}?name=${encodeURIComponent(file.name)}`,
        { method: 'POST', body: await smaller(file) });
      answer = await response.json();
    } catch {
      // There is none.
    }
    this.file.value = '';
    if (answer?.taken) return this.show();
    this.report(answer?.message ?? text.lost);
  }
}
