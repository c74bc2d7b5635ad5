// What came of a job that has ended: its verdict, its report and its picture.
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
    show.addEventListener('click', () => this.show());
    const report = document.createElement('a');
    report.textContent = text.report;
    report.href = `/api/v1/jobs/${job}/report`;
    report.target = '_blank';
    report.rel = 'noopener';
    this.picture.alt = text.picture;
    this.picture.hidden = this.missing.hidden = true;
    this.picture.addEventListener('load', () => (this.picture.hidden = false));
    this.picture.addEventListener('error', () => (this.missing.hidden = false));
    this.element.append(this.verdict, ' ', show, report, this.picture, this.missing);
  }

  /** Again at every press: it is made some seconds after the end. */
  private show() {
    this.picture.hidden = this.missing.hidden = true;
    this.picture.src = `/api/v1/jobs/${this.job}/picture?at=${Date.now()}`;
  }

  update(job: Dict) {
    this.element.hidden = !endStates.includes(job.state);
    this.verdict.textContent = (job.verdict ?? '').replaceAll('_', ' ');
  }
}
