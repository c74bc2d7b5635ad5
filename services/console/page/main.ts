// The page: custom elements that show the console's state. What comes from the shop is text,
// never markup. A reload or a new connection sends nothing.
import { ConsoleLinks } from './console_links';
import { Control } from './control';
import { Dict, askTwice, endStates, make, post } from './dom';
import { FirePanel } from './fire';
import { HistoryList } from './history_list';
import { GlassView } from './glass';
import { JobPage } from './job_page';
import { JogPanel } from './jog';
import { aboutByCell, duration, queueLines } from './queue_time';
import { MachineList } from './machine_list';
import { PhotoPanel } from './photo';
import { ResultPanel } from './result';
import { LogIn, SessionLine, readSession } from './session';
import { TeachPanel } from './teach';
import { LanguageList, fill, text, translatePage } from './text';

class StopButton extends HTMLElement {
  private line = make('span');
  private lost = false;
  private pressedAt = -Infinity;
  control?: Control;

  connectedCallback() {
    const button = make('button', text.stop);
    button.id = 'stop';
    button.title = text.stopHint;
    button.setAttribute('aria-keyshortcuts', 'Escape');
    button.addEventListener('pointerdown', () => this.press());
    button.addEventListener('keydown', (event) => {
      if (event.key === 'Enter' || event.key === ' ') this.press();
    });
    document.addEventListener('keydown', (event) => {
      if (event.key === 'Escape' && !event.repeat) this.press();
    });
    this.line.setAttribute('role', 'status');
    this.append(this.line, button);
    this.connection(false);
  }

  press() {
    this.pressedAt = performance.now();
    this.show(text.stopping);
    this.control?.stop();
  }

  private show(line: string) {
    this.line.textContent = this.lost ? text.lost : line;
    this.line.className = this.lost ? 'lost' : '';
  }

  connection(connected: boolean) {
    this.lost = !connected;
    this.show('');
  }

  /** `held`: a machine is stopped. What confirmed the last press stays as long. */
  follow(stop: Dict | undefined, held: boolean) {
    if (held || performance.now() - this.pressedAt < 5000) this.answer(stop);
    else this.show('');
  }

  answer(stop?: Dict) {
    if (!stop?.sent) return this.show(stop?.message ?? '');
    const machines = (stop.machines ?? []).map((machine: Dict) => {
      if (!machine.confirmed) return `${machine.cell}: ${text.notConfirmed}`;
      const laser = machine.shutters_closed ? `, ${text.shuttersClosed}` : '';
      const stage = machine.at_rest ? text.atRest : text.moving;
      return `${machine.cell}: ${text.confirmed}${laser}, ${stage}`;
    });
    this.show([text.stopping, ...machines, stop.message].filter(Boolean).join('; '));
  }
}

class NeedsList extends HTMLElement {
  update(needs: string[]) {
    const lines = needs.map((need) => make('li', need, 'need'));
    const list = make('ul');
    list.append(...(lines.length ? lines : [make('li', text.nothing, 'quiet')]));
    this.replaceChildren(list);
  }
}

/** A line of the list; it stays the same element while its job is there. */
class JobLine {
  readonly element = make('li');
  private title = make('div');
  private bar = document.createElement('progress');
  private figures = make('div', '', 'quiet');
  private answer = make('div', '', 'need');
  private buttons = make('div');
  private sooner: HTMLElement;
  private later: HTMLElement;
  private fire: FirePanel;
  private results: ResultPanel;

  constructor(private job: number, onShow: () => void) {
    const show = make('button', text.watch);
    show.addEventListener('click', onShow);
    this.buttons.append(show);
    this.command('pause', text.pause);
    this.command('cancel', text.cancel, text.cancelSure);
    this.sooner = this.moveButton(text.sooner);
    this.later = this.moveButton(text.later);
    this.fire = new FirePanel(this.job, (line) => (this.answer.textContent = line));
    this.results = new ResultPanel(this.job);
    this.answer.setAttribute('role', 'status');
    const photo = new PhotoPanel(this.job, (line) => (this.answer.textContent = line));
    this.element.append(this.title, this.bar, this.figures, this.buttons, this.fire.element,
      this.results.element, photo.element, this.answer);
    // Each job has the same buttons: a screen reader reads the title of the job with them.
    this.title.id = `job-${job}-title`;
    this.bar.setAttribute('aria-labelledby', this.title.id);
    for (const control of this.element.querySelectorAll('button, input, a'))
      control.setAttribute('aria-describedby', this.title.id);
  }

  private command(name: string, label: string, question = '') {
    const button = make('button', label);
    button.dataset.command = name;
    const send = () => this.send(name, {});
    if (question) askTwice(button, question, send);
    else button.addEventListener('click', send);
    this.buttons.append(button);
  }

  private async send(name: string, request: Dict) {
    const answer = await post(`jobs/${this.job}/${name}`, request);
    this.answer.textContent = answer?.taken ? '' : answer?.message ?? text.lost;
  }

  /** Its data name the job that this one is to precede. */
  private moveButton(label: string): HTMLElement {
    const button = make('button', label);
    button.addEventListener('click', () => this.send('move', { before: button.dataset.before! }));
    this.buttons.append(button);
    return button;
  }

  /** `queue`: the jobs that wait for the same machine, in their order. */
  private updatePlace(job: Dict, queue: Dict[]) {
    const place = queue.indexOf(job);
    this.sooner.hidden = place < 1;
    this.later.hidden = place < 0 || place === queue.length - 1;
    this.sooner.dataset.before = queue[place - 1]?.uid ?? '';
    this.later.dataset.before = queue[place + 2]?.uid ?? '';
  }

  letGo() {
    this.fire.letGo();
  }

  /** `open`: the job as the status of the shop has it; an ended one is not in it. */
  update(job: Dict, open: Dict | undefined, machine: Dict | undefined, queue: Dict[],
         about: Dict | undefined) {
    this.updatePlace(job, queue);
    this.title.textContent = `${job.job} ${job.name}: ${job.state}`;
    const stages: Dict[] = job.stages ?? [];
    const stage = stages.find((one) => one.done < one.total) ?? stages[stages.length - 1];
    this.bar.max = stage?.total || 1;
    this.bar.value = stage?.done ?? 0;
    const rate = stage?.rate ?? 0;
    const parts = stage
      ? [fill(text.stageProgress, { ...stage, makes: job.makes } as Dict)]
      : [];
    if (rate > 0) parts.push(fill(text.perSecond, { rate: rate.toFixed(0) }));
    if (open?.left_s > 0) parts.push(fill(text.left, { time: duration(open!.left_s) }));
    if (about) parts.push(fill(text.aboutTime, { time: duration(about.time_s) }));
    this.figures.textContent = [...parts, job.message, job.alarm].filter(Boolean).join(', ');
    const ended = endStates.includes(job.state);
    for (const button of this.buttons.querySelectorAll<HTMLElement>('[data-command]'))
      button.hidden = ended || button.dataset.command === 'pause' && job.state === 'paused';
    this.fire.update(job, machine);
    this.results.update(job);
  }
}

class JobList extends HTMLElement {
  private lines = new Map<number, JobLine>();
  private list = make('ul');
  private empty = make('li', text.noJobs, 'quiet');
  private times = make('div', '', 'queue-times quiet');
  onShow: (job: number) => void = () => {};

  connectedCallback() {
    this.append(this.list, this.times);
  }

  /** No button that is held counts any more. */
  letGo() {
    for (const line of this.lines.values()) line.letGo();
  }

  update(jobs: Dict[], shop: Dict, queues: Dict[], about: Dict[]) {
    const machines: Dict[] = shop.machines ?? [];
    const there = new Set<number>(jobs.map((job) => job.job));
    for (const [number, line] of this.lines) {
      if (there.has(number)) continue;
      line.element.remove();
      this.lines.delete(number);
    }
    const waiting = jobs.filter((job) => job.queue_place)
      .sort((one, other) => one.queue_place - other.queue_place);
    for (const job of [...jobs.filter((job) => !job.queue_place), ...waiting]) {
      let line = this.lines.get(job.job);
      if (!line) {
        line = new JobLine(job.job, () => this.onShow(job.job));
        this.lines.set(job.job, line);
        this.list.append(line.element);
      }
      line.update(job, (shop.jobs ?? []).find((open: Dict) => open.uid === job.uid),
        machines.find((machine) => machine.cell === job.cell),
        waiting.filter((other) => other.cell === job.cell),
        about.find((one) => one.uid === job.uid));
    }
    const lines = queueLines(queues, new Date(), aboutByCell(jobs, about));
    this.times.replaceChildren(...lines.map((line) => make('div', line)));
    this.order(waiting);
    if (jobs.length) this.empty.remove();
    else this.list.append(this.empty);
  }

  /** What waits is at the end, in its order. An element that is moved loses the finger that
   * holds it, so none moves that is at its place. */
  private order(waiting: Dict[]) {
    const elements = waiting.map((job) => this.lines.get(job.job)!.element);
    const shown = [...this.list.children].slice(-elements.length || this.list.children.length);
    if (elements.some((element, place) => element !== shown[place]))
      this.list.append(...elements);
  }
}

translatePage();
// The header stays at its place and grows with what Stop reports: whatever gets the focus is
// scrolled to where the header does not cover it.
const header = document.querySelector('header')!;
new ResizeObserver(() => {
  document.documentElement.style.scrollPaddingTop = `${header.offsetHeight + 8}px`;
}).observe(header);
customElements.define('language-list', LanguageList);
customElements.define('session-line', SessionLine);
customElements.define('log-in', LogIn);
customElements.define('stop-button', StopButton);
customElements.define('needs-list', NeedsList);
customElements.define('machine-list', MachineList);
customElements.define('console-links', ConsoleLinks);
customElements.define('job-list', JobList);
customElements.define('jog-panel', JogPanel);
customElements.define('teach-panel', TeachPanel);
customElements.define('job-page', JobPage);
customElements.define('history-list', HistoryList);
customElements.define('glass-view', GlassView);

const stop = document.querySelector('stop-button') as StopButton;
const sessionLine = document.querySelector('session-line') as SessionLine;
const logIn = document.querySelector('log-in') as LogIn;
const needs = document.querySelector('needs-list') as NeedsList;
const machines = document.querySelector('machine-list') as MachineList;
const consoles = document.querySelector('console-links') as ConsoleLinks;
const jobs = document.querySelector('job-list') as JobList;
const newJob = document.querySelector('job-page') as JobPage;
const hand = document.querySelector('jog-panel') as JogPanel;
const teach = document.querySelector('teach-panel') as TeachPanel;
teach.attach(hand);
const glass = document.querySelector('glass-view') as GlassView;
const control = new Control();
stop.control = control;
function letGo() {
  jobs.letGo();
  hand.letGo();
}
control.onJog = (view) => hand.take(view);
control.onRefusal = (message) => hand.refuse(message);
hand.send = (message) => control.send(message);
control.onConnection = (connected) => {
  letGo();
  stop.connection(connected);
  showSession();
};

/** The log-in in place of the shop, while nobody is logged in. */
async function showSession(here = false) {
  const session = await readSession(here);
  if (session === null) return;
  sessionLine.update(session);
  logIn.hidden = !!session && !session.rests;
  document.querySelector('main')!.hidden = !session;
}
sessionLine.onChange = logIn.onChange = () => {
  letGo();
  showSession();
};
showSession();
// A page in view stays logged in, to look; touches keep the right to command.
setInterval(() => document.hidden || showSession(), 5 * 60 * 1000);
let touchedAt = performance.now();
for (const touch of ['pointerdown', 'keydown']) {
  document.addEventListener(touch, () => {
    if (performance.now() - touchedAt < 60 * 1000) return;
    touchedAt = performance.now();
    showSession(true);
  });
}
document.addEventListener('visibilitychange', letGo);
window.addEventListener('blur', letGo);
window.addEventListener('pagehide', letGo);
control.onStop = (answer) => stop.answer(answer);
const history = document.querySelector('history-list') as HistoryList;
jobs.onShow = (job) => glass.show(job);
history.onShow = (job) => glass.show(job);
let drawnAt = 0;
control.onState = (state) => {
  const held = (state.shop?.machines ?? []).some((machine: Dict) => machine.stops_held?.length);
  stop.follow(state.stop ?? undefined, held);
  if (performance.now() - drawnAt < 200 || document.hidden) return;
  drawnAt = performance.now();
  sessionLine.showCharge(state.in_charge ?? '');
  needs.update(state.shop?.needs ?? []);
  machines.update(state.shop?.machines ?? [], state.stages ?? []);
  consoles.update(state.shop?.services ?? []);
  hand.update(state.shop?.machines ?? []);
  newJob.follow(state.shop?.machines ?? []);
  teach.update(state.jobs ?? []);
  jobs.update(state.jobs ?? [], state.shop ?? {}, state.queues ?? [], state.about ?? []);
  glass.follow(state.jobs ?? []);
  glass.showFocus(state.jobs ?? [], state.stages ?? []);
};
