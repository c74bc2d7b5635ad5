// What the elements of the page have in common.
export type Dict = Record<string, any>;

export const endStates = ['done', 'failed', 'cancelled'];

/** An element with a text; the text is never read as markup. */
export function make(tag: string, content = '', className = ''): HTMLElement {
  const element = document.createElement(tag);
  element.textContent = content;
  if (className) element.className = className;
  return element;
}

/** A row of a list to choose from. */
export function option(value: string, name: string): HTMLOptionElement {
  const row = document.createElement('option');
  row.value = value;
  row.textContent = name;
  return row;
}

/** A control with its name before it. */
export function labelled(name: string, control: HTMLElement): HTMLElement {
  const label = make('label', `${name} `);
  label.append(control);
  return label;
}

/** The answer of the console, also when it refuses; undefined: there was none. */
export function post(path: string, body: Dict): Promise<Dict | undefined> {
  return ask(path, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify(body),
  });
}

/** The same without a body. */
export function get(path: string): Promise<Dict | undefined> {
  return ask(path, {});
}

async function ask(path: string, request: RequestInit): Promise<Dict | undefined> {
  try {
    const response = await fetch(`/api/v1/${path}`, request);
    return await response.json();
  } catch {
    return undefined;
  }
}

/** A button whose second press within 4 s counts, once it has asked; no dialog, which would take
 * the page away from Stop. */
export function askTwice(button: HTMLElement, question: string, act: () => void,
                         onAsk: () => void = () => {}) {
  const label = button.textContent;
  let isAsked = false;
  const forget = () => {
    isAsked = false;
    button.textContent = label;
  };
  button.addEventListener('click', () => {
    if (isAsked) {
      forget();
      return act();
    }
    isAsked = true;
    onAsk();
    button.textContent = question;
    setTimeout(forget, 4000);
  });
}
