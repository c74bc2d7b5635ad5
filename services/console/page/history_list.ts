// What the shop has made: the jobs that have ended, the newest first, with the reason where one
// did not end well, and for each what is kept of it: report, picture, photo, glass.
import { Dict, get, labelled, make, option } from './dom';
import { PhotoPanel } from './photo';
import { duration } from './queue_time';
import { ResultPanel } from './result';
import { fill, fillCounted, text } from './text';

const shownJobs = 50;
const verdicts = ['', 'good', 'good_with_warnings', 'not_good', 'none', 'unknown'];

export class HistoryList extends HTMLElement {
  private name = document.createElement('input');
  private since = document.createElement('input');
  private verdict = document.createElement('select');
  private list = make('ul');
  private answer = make('div', '', 'quiet');
  private asked = 0;  // number of the newest question
  onShow: (job: string) => void = () => {};

  connectedCallback() {
    this.since.placeholder = new Date().toISOString().slice(0, 10);
    this.verdict.append(...verdicts.map((verdict) =>
      option(verdict, verdict.replaceAll('_', ' ') || text.anyVerdict)));
    const show = make('button', text.showHistory);
    show.addEventListener('click', () => this.ask());
    this.answer.setAttribute('role', 'status');
    const table = document.createElement('a');
    table.textContent = text.asTable;
    table.href = '/api/v1/history.csv';
    this.append(labelled(text.jobName, this.name), labelled(text.sinceDay, this.since),
      labelled(text.verdict, this.verdict), show, table, this.answer, this.list);
  }

  private async ask() {
    const asked = ++this.asked;
    const query = new URLSearchParams();
    const filters = { name: this.name, since: this.since, verdict: this.verdict };
    for (const [name, field] of Object.entries(filters))
      if (field.value) query.set(name, field.value);
    this.answer.textContent = text.computing;
    const history = await get(`history?${query}`);
    if (asked !== this.asked) return;
    if (!history || history.message) {
      this.list.replaceChildren();
      this.answer.textContent = history?.message ?? text.lost;
      return;
    }
    const jobs: Dict[] = history.jobs ?? [];
    this.answer.textContent = fillCounted(text.historyCount, jobs.length,
      { jobs: jobs.length, shown: Math.min(jobs.length, shownJobs) });
    this.list.replaceChildren(
      ...jobs.slice(-shownJobs).reverse().map((job) => this.line(job)));
  }

  private line(job: Dict): HTMLElement {
    const item = make('li');
    const title = make('div', `${job.job} ${job.name}: ${job.state}`);
    title.id = `history-${job.uid}`;
    const ended = new Date(job.ended_utc);
    const figures = [
      job.cell, Number.isNaN(ended.getTime()) ? '' : ended.toLocaleString(), job.material,
      fill(text.madeOf, { made: job.made ?? 0, planned: job.planned ?? 0 }),
      job.machining_s ? duration(job.machining_s) : '',
    ];
    item.append(title, make('div', figures.filter(Boolean).join(', '), 'quiet'));
    const isGood = ['good', 'good_with_warnings'].includes(job.verdict ?? '');
    if (job.message) item.append(make('div', job.message, isGood ? 'quiet' : 'need'));
    const answer = make('div', '', 'need');
    const show = make('button', text.watch);
    show.addEventListener('click', () => this.onShow(job.uid));
    const results = new ResultPanel(job.uid);
    results.update(job);
    const photo = new PhotoPanel(job.uid, (line) => (answer.textContent = line));
    item.append(show, results.element, photo.element, answer);
    for (const control of item.querySelectorAll('button, input, a'))
      control.setAttribute('aria-describedby', title.id);
    return item;
  }
}
