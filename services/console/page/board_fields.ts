// What a board, plate or sheet needs that a mill or a cutter makes: a job of contours.
import { Card, ChoiceCards } from './choice_cards';
import { Dict, labelled, make } from './dom';
import { stroke } from './job_pictures';
import { text } from './text';

/** Files of circuit boards; drawings are taken, too. */
export const boardFiles =
  /\.(gbr|ger|gt[lsop]|gb[lsop]|gko|gm\d+|drl|xln|exc|ncd|kicad_pcb|cmp|sol)$/i;

const makes = ['isolation', 'outline', 'curves', 'pocket', 'cut'];
const numbers: [string, string, string][] = [
  ['tool_diameter_mm', text.toolDiameter, '0.2'],
  ['depth_mm', text.cutDepth, '0.2'],
  ['drill_depth_mm', text.drillDepth, '3'],
];

function drawMake(make_: string): (picture: CanvasRenderingContext2D) => void {
  return (picture) => {
    const line = (wide: number, colour: string, places: number[][]) =>
      stroke(picture, colour, places, true, wide);
    const body = [[28, 18], [68, 18], [68, 42], [52, 42], [52, 56], [28, 56]];
    const way = [[22, 12], [74, 12], [74, 48], [58, 48], [58, 62], [22, 62]];
    picture.fillStyle = make_ === 'pocket' ? '#0b0e12' : '#b87333';
    picture.beginPath();
    body.forEach(([x, y], place) => (place ? picture.lineTo(x, y) : picture.moveTo(x, y)));
    picture.closePath();
    if (make_ !== 'curves') picture.fill();
    if (make_ === 'isolation' || make_ === 'outline')
      line(make_ === 'isolation' ? 6 : 2, '#e8edf2', way);
    if (make_ === 'curves') line(2, '#e8edf2', body);
    if (make_ === 'cut') line(4, '#e8edf2', body);
    if (make_ === 'pocket') {
      for (const y of [24, 30, 36]) line(3, '#e8edf2', [[32, y], [64, y]]);
      for (const y of [42, 48]) line(3, '#e8edf2', [[32, y], [48, y]]);
      line(2, '#b87333', body);
    }
  };
}

export class BoardFields {
  readonly element = make('div');
  private make: ChoiceCards;
  private fields: Record<string, HTMLInputElement> = {};

  constructor(onChange: () => void) {
    this.make = new ChoiceCards(text.boardMake, onChange);
    this.make.show(makes.map((name): Card => ({
      value: name,
      name: text[`make_${name}` as keyof typeof text],
      draw: drawMake(name),
    })), makes[0]);
    this.element.append(this.make.element, ...numbers.map(([name, label, value]) => {
      const field = document.createElement('input');
      Object.assign(field, { type: 'number', step: 'any', min: '0', value });
      field.addEventListener('input', onChange);
      this.fields[name] = field;
      return labelled(label, field);
    }));
  }

  /** JobSpec.course. */
  course(files: File[]): Dict {
    const figures = numbers.map(([name]) => [name, Number(this.fields[name].value) || 0]);
    return {
      files: files.map((file) => file.name),
      make: `COURSE_MAKE_${this.make.value.toUpperCase()}`,
      ...Object.fromEntries(figures.filter(([, value]) => value)),
    };
  }
}
