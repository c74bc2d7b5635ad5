// The pictures of the cards of a new job: methods as the points that they make, glasses as a block
// in the light, machines as what moves over the block.
import { Dict } from './dom';
import { pictureHeight as height, pictureWidth as width } from './choice_cards';

type Picture = CanvasRenderingContext2D;
const light = '#e8edf2', line = '#a9b6c4', beam = '#ff5d5d', block = '#4f7fa8';
const centre = [width / 2, height / 2];
const radius = 30;

function dot(picture: Picture, x: number, y: number) {
  picture.fillStyle = light;
  picture.fillRect(x - 0.8, y - 0.8, 1.6, 1.6);
}

/** A line of this width along places of the picture. */
export function stroke(picture: Picture, colour: string, places: number[][], closed = false,
                       wide = 2) {
  picture.strokeStyle = colour;
  picture.lineWidth = wide;
  picture.beginPath();
  places.forEach(([x, y], place) => (place ? picture.lineTo(x, y) : picture.moveTo(x, y)));
  if (closed) picture.closePath();
  picture.stroke();
}

/** A point of the unit sphere, seen from in front and a little above. */
function onSphere(picture: Picture, x: number, y: number, z: number) {
  const lean = 0.35;
  const up = z * Math.cos(lean) + y * Math.sin(lean);
  dot(picture, centre[0] + radius * x, centre[1] - radius * up);
}

/** The same sequence for each picture, 0..1. */
function sequence(): () => number {
  let state = 1;
  return () => (state = (state * 16807) % 2147483647) / 2147483647;
}

function grid(step: number, draw: (x: number, y: number) => void) {
  for (let y = step / 2; y < height; y += step)
    for (let x = step / 2; x < width; x += step) draw(x, y);
}

const methodPictures: Record<string, (picture: Picture) => void> = {
  even(picture) {
    const golden = Math.PI * (3 - Math.sqrt(5));
    for (let i = 0, count = 320; i < count; i++) {
      const z = 1 - (2 * i + 1) / count;
      const wide = Math.sqrt(1 - z * z);
      onSphere(picture, wide * Math.cos(golden * i), wide * Math.sin(golden * i), z);
    }
  },
  sections(picture) {
    for (let z = -0.9; z < 0.95; z += 0.2) {
      const wide = Math.sqrt(1 - z * z);
      const count = Math.round(40 * wide);
      for (let i = 0; i < count; i++) {
        const turn = 2 * Math.PI * i / count;
        onSphere(picture, wide * Math.cos(turn), wide * Math.sin(turn), z);
      }
    }
  },
  fill(picture) {
    const corners = [[48, 4], [10, 50], [86, 50], [48, 68]];
    for (const [a, b, c] of [[0, 1, 3], [0, 2, 3]]) {
      const steps = 13;
      for (let i = 0; i <= steps; i++) {
        for (let j = 0; i + j <= steps; j++) {
          const place = [0, 1].map((axis) => corners[a][axis] +
            (corners[b][axis] - corners[a][axis]) * i / steps +
            (corners[c][axis] - corners[a][axis]) * j / steps);
          dot(picture, place[0], place[1]);
        }
      }
    }
  },
  rays(picture) {
    grid(5, (x, y) => {
      if (Math.hypot(x - centre[0], y - centre[1]) < radius) dot(picture, x, y);
    });
  },
  solid(picture) {
    const random = sequence();
    for (let i = 0; i < 900; i++) {
      const [x, y] = [random() * width, random() * height];
      if (Math.hypot(x - centre[0], y - centre[1]) < radius) dot(picture, x, y);
    }
  },
  curves(picture) {
    for (let i = 0; i < 150; i++) {
      const turn = 2 * Math.PI * i / 150;
      const far = radius * (0.7 + 0.3 * Math.cos(5 * turn));
      dot(picture, centre[0] + far * Math.sin(turn), centre[1] - far * Math.cos(turn));
    }
  },
  halftone(picture) {
    const random = sequence();
    grid(3, (x, y) => {
      const bright = Math.max(0, 1 - Math.hypot(x - 40, y - 28) / 45);
      if (random() < bright) dot(picture, x, y);
    });
  },
  relief(picture) {
    for (let row = 12; row < height; row += 5) {
      for (let x = 8; x < width - 8; x += 3) {
        const far = Math.hypot(x - centre[0], 1.6 * (row - centre[1]));
        dot(picture, x, row + 4 - 16 * Math.exp(-far * far / 500));
      }
    }
  },
};
const usualMethods: Record<string, string> = { even: 'sections' };

/** `methods`: those of a kind of file; '' has the picture of its default. */
export function drawMethod(method: string, methods: string[]): (picture: Picture) => void {
  return methodPictures[method || usualMethods[methods[0]] || methods[0]] ?? (() => {});
}

/** The darker a block, the less light it lets through; a beam bends at its face by its index. */
export function drawGlass(glass: Dict): (picture: Picture) => void {
  return (picture) => {
    const clear = glass.transmitted_ratio || 1;
    picture.globalAlpha = 0.25 + 0.5 * (1 - clear);
    picture.fillStyle = block;
    picture.fillRect(16, 26, 64, 42);
    picture.globalAlpha = 1;
    stroke(picture, line, [[16, 26], [80, 26], [80, 68], [16, 68]], true);
    const air = 0.75;  // rad from the normal
    const inside = Math.asin(Math.sin(air) / (glass.index || 1.5));
    const enter = [44, 26];
    stroke(picture, beam, [[enter[0] - 24 * Math.tan(air), 2], enter,
      [enter[0] + 40 * Math.tan(inside), 66]]);
  };
}

const machinePictures: Record<string, (picture: Picture) => void> = {
  cartesian(picture) {
    stroke(picture, line, [[12, 62], [12, 8], [84, 8], [84, 62]]);
    stroke(picture, line, [[40, 8], [40, 24], [56, 24], [56, 8]]);
    stroke(picture, beam, [[48, 24], [48, 54]]);
  },
  polar(picture) {
    stroke(picture, line, [[10, 62], [10, 14], [48, 14], [48, 24]]);
    picture.beginPath();
    picture.ellipse(48, 66, 34, 5, 0, 0, 2 * Math.PI);
    picture.stroke();
    stroke(picture, beam, [[48, 24], [48, 54]]);
  },
  head_over_block(picture) {
    stroke(picture, line, [[30, 6], [44, 18]]);
    stroke(picture, line, [[30, 24], [66, 24], [60, 30], [36, 30]], true);
    stroke(picture, beam, [[4, 12], [37, 12], [42, 27], [58, 56]]);
  },
  marks(picture) {
    stroke(picture, line, [[30, 6], [44, 18]]);
    stroke(picture, line, [[30, 24], [66, 24], [60, 30], [36, 30]], true);
    stroke(picture, beam, [[4, 12], [37, 12], [42, 27], [62, 60]]);
  },
  courses(picture) {
    stroke(picture, line, [[38, 4], [58, 4], [58, 34], [38, 34]], true);
    stroke(picture, line, [[44, 34], [48, 60], [52, 34]], true);
  },
};

export function drawMachine(machine: Dict): (picture: Picture) => void {
  return (picture) => {
    const inGlass = machine.makes === 'points';
    picture.fillStyle = block;
    picture.globalAlpha = 0.4;
    if (inGlass) picture.fillRect(28, 38, 44, 26);
    else picture.fillRect(12, 60, 72, 5);
    picture.globalAlpha = 1;
    (machinePictures[inGlass ? machine.kinematics : machine.makes] ??
      machinePictures.cartesian)(picture);
  };
}

export function drawKind(kind: string): (picture: Picture) => void {
  if (kind === 'board') return drawMachine({ makes: 'courses' });
  return (picture) => {
    stroke(picture, line, [[20, 8], [76, 8], [76, 66], [20, 66]], true);
    picture.save();
    picture.translate(15, 11);
    picture.scale(0.7, 0.7);
    methodPictures.even(picture);
    picture.restore();
  };
}
