// The texts of the page, in the language that was chosen, or the browser's. What comes from the
// shop, names and messages, is shown as it is.
import { option } from './dom';
import de from './texts/de.json';
import en from './texts/en.json';
import es from './texts/es.json';
import pl from './texts/pl.json';
import zh from './texts/zh.json';

export type Texts = typeof en;
const catalogues: Record<string, Texts> = { en, de, es, pl, zh };
const names: Record<string, string> = {
  en: 'English', de: 'Deutsch', es: 'Español', pl: 'Polski', zh: '中文',
};
const chosenName = 'language';

/** Where nothing may be kept, the browser's language counts. */
function chosen(): string | null {
  try {
    return localStorage.getItem(chosenName);
  } catch {
    return null;
  }
}

function firstKnown(): string {
  for (const wanted of [chosen() ?? '', ...navigator.languages]) {
    const language = wanted.slice(0, 2).toLowerCase();
    if (language in catalogues) return language;
  }
  return 'en';
}

export const language = firstKnown();
export const text: Texts = catalogues[language];

/** A text with its places, "{name}", filled in. */
export function fill(pattern: string, values: Record<string, string | number>): string {
  return pattern.replace(/\{(\w+)\}/g, (place, name) => String(values[name] ?? place));
}

const plurals = new Intl.PluralRules(language);

/**
 * A text that counts: the form for this count, "one: {points} point | other: {points} points" by
 * the categories of Intl.PluralRules, with its places filled in and its numbers grouped.
 */
export function fillCounted(
    pattern: string, count: number, values: Record<string, string | number>): string {
  const forms = new Map(pattern.split(' | ').map((form): [string, string] => {
    const colon = form.indexOf(': ');
    return [form.slice(0, colon), form.slice(colon + 2)];
  }));
  const form = forms.get(plurals.select(count)) ?? forms.get('other') ?? pattern;
  const shown = Object.fromEntries(Object.entries(values).map(([name, value]) =>
    [name, typeof value === 'number' ? value.toLocaleString(language) : value]));
  return fill(form, shown);
}

/** A list of the languages; a choice loads the page again, which sends nothing. */
export class LanguageList extends HTMLElement {
  connectedCallback() {
    const list = document.createElement('select');
    list.setAttribute('aria-label', text.language);
    for (const [code, name] of Object.entries(names)) {
      const row = option(code, name);
      row.lang = code;
      row.selected = code === language;
      list.append(row);
    }
    list.addEventListener('change', () => {
      try {
        localStorage.setItem(chosenName, list.value);
      } catch {
        return;
      }
      location.reload();
    });
    this.append(list);
  }
}

/** Elements of the page's file: data-text names their text. */
export function translatePage() {
  document.documentElement.lang = language;
  for (const element of document.querySelectorAll<HTMLElement>('[data-text]'))
    element.textContent = text[element.dataset.text as keyof Texts];
}
