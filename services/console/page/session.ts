// Who is logged in, who is in charge, and the log-in. Nothing of it lets a machine move or fire.
import { Dict, make, post } from './dom';
import { fill, text } from './text';

function field(type: string, label: string, autocomplete: string): [HTMLElement, HTMLInputElement] {
  const line = make('label', label);
  const input = document.createElement('input');
  input.type = type;
  input.autocomplete = autocomplete;
  input.required = true;
  line.append(' ', input);
  return [line, input];
}

/** In the header: the person, and the one in charge. */
export class SessionLine extends HTMLElement {
  private person = make('span');
  private charge = make('span');
  private take = make('button', text.takeOver);
  private leave = make('button', text.logOut);
  private session?: Dict;
  onChange: () => void = () => {};

  connectedCallback() {
    this.take.addEventListener('click', async () => {
      await post('charge', {});
      this.onChange();
    });
    this.leave.addEventListener('click', async () => {
      await post('logout', {});
      this.onChange();
    });
    this.append(this.person, this.charge, this.take, this.leave);
    this.update(undefined);
  }

  update(session: Dict | undefined) {
    this.session = session;
    this.hidden = !session;
    document.body.dataset.role = session?.role ?? '';
    const role = session?.rests ? text.rests : text[session?.role as 'operator'];
    this.person.textContent = session ? `${session.name} (${role})` : '';
    this.person.className = session?.rests ? 'need' : '';
    this.showCharge(session?.in_charge ?? '');
  }

  showCharge(name: string) {
    const isOperator = this.session?.role === 'operator';
    const isOther = !!name && name !== this.session?.name;
    this.charge.textContent = name ? fill(text.inCharge, { name }) : '';
    this.charge.className = isOther ? 'need' : '';
    this.take.hidden = !isOperator || !isOther;
  }
}

/** The form, while nobody is logged in. */
export class LogIn extends HTMLElement {
  private answer = make('div', '', 'need');
  onChange: () => void = () => {};

  connectedCallback() {
    const form = document.createElement('form');
    const [nameLine, name] = field('text', text.name, 'username');
    const [passwordLine, password] = field('password', text.password, 'current-password');
    const send = make('button', text.logIn);
    this.answer.setAttribute('role', 'alert');
    form.append(nameLine, passwordLine, send, this.answer);
    form.addEventListener('submit', async (event) => {
      event.preventDefault();
      const answer = await post('login', { name: name.value, password: password.value });
      password.value = '';
      this.answer.textContent = answer?.role ? '' : answer?.message ?? text.lost;
      this.onChange();
    });
    this.append(make('p', text.logInHint, 'quiet'), form);
  }
}

/** undefined: nobody is logged in here; null: that is not known, there was no answer. `here`:
 * because a person touched the page. */
export async function readSession(here = false): Promise<Dict | undefined | null> {
  try {
    const response = await fetch(`/api/v1/session${here ? '?here=1' : ''}`);
    if (response.status === 401) return undefined;
    return response.ok ? await response.json() : null;
  } catch {
    return null;
  }
}
