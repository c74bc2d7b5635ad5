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

/** A control with its name before it. */
export function labelled(name: string, control: HTMLElement): HTMLElement {
  const label = make('label', `${name} `);
  label.append(control);
  return label;
}

/** The answer of the console, also when it refuses; undefined: there was none. */
export async function post(path: string, body: Dict): Promise<Dict | undefined> {
  try {
    const response = await fetch(`/api/v1/${path}`, {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify(body),
    });
    return await response.json();
  } catch {
    return undefined;
  }
}
