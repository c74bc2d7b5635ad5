// console_keyboard_test.py runs these functions in the page: they find its controls, whether the
// focus is seen, and texts that are too faint. Contrast is that of WCAG 2.1, "relative luminance" and
// "contrast ratio".
const isShown = (element) => element.getClientRects().length > 0 &&
  getComputedStyle(element).visibility === 'visible';

/** [r, g, b, alpha] of a computed colour. */
function colour(text) {
  const numbers = (text.match(/[\d.]+/g) ?? []).map(Number);
  return text.startsWith('rgb') ? [...numbers.slice(0, 3), numbers[3] ?? 1] : [0, 0, 0, 0];
}

function over(top, below) {
  return [...[0, 1, 2].map((i) => top[i] * top[3] + below[i] * (1 - top[3])), 1];
}

/** Every colour that may lie behind what the element shows: its own, and those of its gradients. */
function backgrounds(element) {
  if (!element) return [[255, 255, 255, 1]];
  const style = getComputedStyle(element);
  const own = colour(style.backgroundColor);
  const gradients = (style.backgroundImage.match(/rgba?\([^)]*\)/g) ?? []).map(colour);
  const below = own[3] === 1 ? [own]
    : backgrounds(element.parentElement).map((one) => over(own, one));
  return [...below, ...gradients.flatMap((top) => below.map((one) => over(top, one)))];
}

function luminance(rgb) {
  const [r, g, b] = rgb.map((value) => value / 255)
    .map((value) => value <= 0.03928 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

function contrast(front, behind) {
  const [one, other] = [over(front, behind), behind].map(luminance).sort((a, b) => b - a);
  return (one + 0.05) / (other + 0.05);
}

const worst = (front, element) =>
  Math.min(...backgrounds(element).map((behind) => contrast(front, behind)));

window.keyboardTest = {
  /** What a person can use, in the order of the document. Tab reaches the chosen one of a group of
   * radio buttons, and the arrow keys the others. */
  controls: () => [...document.querySelectorAll(
    'a[href], button, input, select, textarea, summary, canvas, [contenteditable], [tabindex]')]
    .filter((element) => isShown(element) && !element.disabled && !element.ariaHidden &&
      (element.type !== 'radio' || element.checked)),
  /** What has to have a name besides. */
  named: () => [...document.querySelectorAll('img, progress, meter, [role=img]')].filter(isShown),
  positiveTabindex: () => [...document.querySelectorAll('[tabindex]')]
    .filter((element) => element.tabIndex > 0).length,
  /** Why the focus is not seen on its element; empty: it is. */
  focusFault() {
    const element = document.activeElement;
    const style = getComputedStyle(element);
    const width = parseFloat(style.outlineWidth);
    if (style.outlineStyle === 'none' || width < 2) return `outline ${style.outline}`;
    const ratio = worst(colour(style.outlineColor), element.parentElement);
    if (ratio < 3) return `outline of contrast ${ratio.toFixed(2)}`;
    const box = element.getBoundingClientRect();
    const at = document.elementFromPoint(box.left + Math.min(box.width / 2, innerWidth / 2),
      box.top + Math.min(box.height / 2, 20));
    if (at && (element.contains(at) || at.contains(element))) return '';
    return `behind ${at?.outerHTML?.slice(0, 60)}`;
  },
  /** Texts of too little contrast: [ratio, text]. */
  faintTexts(least) {
    const faint = [];
    const check = (front, element, text) => {
      const ratio = worst(colour(front), element);
      if (ratio < least) faint.push([Number(ratio.toFixed(2)), text.trim().slice(0, 60)]);
    };
    const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    let checked = 0;
    while (texts.nextNode()) {
      const element = texts.currentNode.parentElement;
      if (!texts.currentNode.data.trim() || element.tagName === 'OPTION') continue;
      if (!isShown(element)) continue;
      if (getComputedStyle(element).opacity !== '1') faint.push([0, 'opacity']);
      ++checked;
      check(getComputedStyle(element).color, element, texts.currentNode.data);
    }
    for (const field of document.querySelectorAll('input, select, textarea')) {
      if (!isShown(field) || field.type === 'checkbox') continue;
      ++checked;
      const style = getComputedStyle(field);
      check(style.color, field, `value of ${field.type}`);
      if (field.placeholder)
        check(getComputedStyle(field, '::placeholder').color, field, field.placeholder);
      if (field.type !== 'file') continue;
      const button = getComputedStyle(field, '::file-selector-button');
      const ratio = contrast(colour(button.color),
        over(colour(button.backgroundColor), backgrounds(field)[0]));
      if (ratio < least) faint.push([Number(ratio.toFixed(2)), 'button of a file']);
    }
    return { checked, faint };
  },
};
