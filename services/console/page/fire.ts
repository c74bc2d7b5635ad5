// What lets a machine fire: arm and resume, by a button that a person presses and holds. The
// console checks the hold itself; nothing that is chosen here is remembered.
import { Dict, endStates, make, post } from './dom';
import { text } from './text';

function input(type: string, label: string): [HTMLElement, HTMLInputElement] {
  const line = make('label', label);
  const field = document.createElement('input');
  field.type = type;
  line.append(' ', field);
  return [line, field];
}

/** Below a job that may be armed, resumed, or made slower. */
export class FirePanel {
  readonly element = make('div', '', 'fire');
  private block = make('div');
  private button = make('button', '', 'hold') as HTMLButtonElement;
  private consentLine: HTMLElement;
  private consent: HTMLInputElement;
  private fromLine: HTMLElement;
  private from: HTMLInputElement;
  private uncertainLine: HTMLElement;
  private uncertain: HTMLInputElement;
  private speed: HTMLInputElement;
  private mounted = '';
  private resumes = false;
  private press = 0;  // its number; 0: it is not held
  private presses = 0;
  private timer = 0;

  constructor(private job: number, private report: (line: string) => void) {
    [this.consentLine, this.consent] = input('checkbox', text.consent);
    [this.fromLine, this.from] = input('number', text.from);
    this.from.min = '0';
    [this.uncertainLine, this.uncertain] = input('checkbox', text.fireUncertain);
    const [speedLine, speed] = input('number', text.speed);
    this.speed = speed;
    Object.assign(speed, { min: '1', max: '140', className: 'speed' });
    const set = make('button', text.setSpeed);
    set.addEventListener('click', () => this.setSpeed());
    const speeds = make('div');
    speeds.append(speedLine, set);
    this.button.addEventListener('pointerdown', (event) => {
      if (event.isPrimary && event.button === 0) this.hold();
    });
    for (const end of ['pointerup', 'pointercancel', 'pointerleave', 'keyup', 'blur'])
      this.button.addEventListener(end, () => this.letGo());
    this.button.addEventListener('contextmenu', (event) => event.preventDefault());
    this.button.addEventListener('keydown', (event) => {
      if (!event.repeat && (event.key === 'Enter' || event.key === ' ')) this.hold();
    });
    this.element.append(this.block, this.consentLine, this.fromLine, this.uncertainLine,
      this.button, speeds);
  }

  letGo() {
    this.press = 0;
    clearTimeout(this.timer);
    this.button.classList.remove('held');
  }

  private async hold() {
    this.letGo();
    const press = (this.press = ++this.presses);
    const isHeld = () => this.press === press;
    const answer = await post(`jobs/${this.job}/hold`, { block: this.mounted });
    if (!isHeld()) return;
    if (!answer?.held) {
      this.letGo();
      return this.report(answer?.message ?? text.lost);
    }
    this.button.style.setProperty('--hold', `${answer.hold_s}s`);
    this.button.classList.add('held');
    this.timer = window.setTimeout(() => isHeld() && this.fire(answer.token),
      answer.hold_s * 1000 + 100);
  }

  private async fire(token: string) {
    this.letGo();
    const body: Dict = { token, accept_breakage: this.consent.checked };
    if (this.resumes) {
      body.from_point = Number(this.from.value) || 0;
      body.fire_uncertain = this.uncertain.checked;
    }
    this.consent.checked = this.uncertain.checked = false;
    this.from.value = '';
    const answer = await post(`jobs/${this.job}/${this.resumes ? 'resume' : 'arm'}`, body);
    this.report(answer?.taken ? '' : answer?.message ?? text.lost);
  }

  private async setSpeed() {
    const answer = await post(`jobs/${this.job}/speed`, { percent: Number(this.speed.value) || 0 });
    this.report(answer?.taken ? '' : answer?.message ?? text.lost);
  }

  update(job: Dict, machine: Dict | undefined) {
    const ended = endStates.includes(job.state);
    this.element.hidden = ended || job.state === 'queued';
    this.resumes = job.state === 'paused';
    const mounted = machine?.mounted ?? '';
    if (mounted !== this.mounted) this.letGo();
    this.mounted = mounted;
    this.block.textContent = `${job.cell}: ${mounted || text.notMounted}`;
    this.button.textContent = this.resumes ? text.holdToResume : text.holdToArm;
    const waits = !job.armed;
    const consent = (job.warnings ?? []).find((one: Dict) => one.weight === 'consent');
    this.consentLine.hidden = !waits || !consent || !!job.breakage_accepted_by;
    this.consentLine.title = consent?.text ?? '';
    this.fromLine.hidden = !waits || !this.resumes;
    this.uncertainLine.hidden = !waits || !this.resumes || !job.uncertain;
    this.button.hidden = this.block.hidden = !waits;
    this.speed.placeholder = String(job.speed_percent ?? 100);
  }
}
