// What came of a job that has ended: its verdict, its report, the customer's picture, and the
// proof with its deviations.
import { Dict, endStates, make } from './dom';
import { text } from './text';

export class ResultPanel {
  readonly element = make('div', '', 'result');
  private verdict = make('span');
  private picture = document.createElement('img');
  private missing = make('div', text.noPicture, 'quiet');

  /** `job`: number or uid. */
  constructor(private job: number | string) {
    const show = make('button', text.picture);
    show.addEventListener('click', () => this.show('picture'));
    const proof = make('button', text.proof);
    proof.addEventListener('click', () => this.show('views'));
    const report = document.createElement('a');
    report.textContent = text.report;
    report.href = `/api/v1/jobs/${job}/report`;
    report.target = '_blank';
    report.rel = 'noopener';
    this.picture.hidden = this.missing.hidden = true;
    this.picture.addEventListener('load', () => (this.picture.hidden = false));
    this.picture.addEventListener('error', () => (this.missing.hidden = false));
    this.element.append(this.verdict, ' ', show, proof, report, this.picture, this.missing);
  }

  /** Again at every press: it is made some seconds after the end. */
  private show(part: 'picture' | 'views') {
    this.picture.hidden = this.missing.hidden = true;
    this.picture.alt = part === 'views' ? text.proof : text.picture;
    this.picture.src = `/api/v1/jobs/${this.job}/${part}?at=${Date.now()}`;
  }

  update(job: Dict) {
    this.element.hidden = !endStates.includes(job.state);
    this.verdict.textContent = (job.verdict ?? '').replaceAll('_', ' ');
  }
}
