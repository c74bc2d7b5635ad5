// The colours of points, as they are drawn and as the legend has them: red, green and blue, 0..1.
export type Colour = [number, number, number];

/** What the colour of a point shows. */
export const modes = ['outcome', 'order', 'tick', 'channel'] as const;
export type Mode = typeof modes[number];

/** By PointOutcome (engrave/formats/journal_file.h); 0: not fired yet. */
export const ofOutcome: Colour[] = [
  [0.55, 0.7, 0.9], [1, 1, 1], [1, 0.45, 0.1], [0.95, 0.85, 0.2], [1, 0.25, 0.9], [0.1, 0.8, 0.6],
];
/** Channels 1 to 4; what is made in several has their mean. */
export const ofChannel: Colour[] = [
  [0.35, 0.65, 1], [1, 0.6, 0.15], [0.45, 0.9, 0.35], [0.95, 0.4, 0.75],
];
export const first: Colour = [0.25, 0.55, 1];
export const last: Colour = [1, 0.8, 0.2];

export function css(colour: Colour): string {
  return `rgb(${colour.map((part) => Math.round(255 * part)).join(', ')})`;
}
