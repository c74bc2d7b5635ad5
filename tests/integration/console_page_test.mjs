// Parts of the console's page that need no browser: the decoder of a plan, what of a cloud a
// frame draws, the budget of a frame, the numbers that a graphics card gets, and the lines of the
// queues and the machines.
//   esbuild --bundle --platform=node --alias:three=MODULE console_page_test.mjs |
//     node - REPOSITORY
import { readFileSync } from 'fs';
import { FrameBudget, Picture, cellsInView } from '../../services/console/page/cells';
import { Cloud } from '../../services/console/page/cloud';
import { PlanDecoder } from '../../services/console/page/plan';
import { Ticks } from '../../services/console/page/ticks';

let failed = 0;
function expect(is, what) {
  if (is) return;
  ++failed;
  console.error(`failed: ${what}`);
}

function fails(work, what) {
  try {
    work();
  } catch {
    return;
  }
  expect(false, what);
}

// plan_packer_test.cc makes these bytes of points at (1.25 i, 50 - 0.3 i, 2.5 or 2.6) mm.
const hex = readFileSync(`${process.argv[2]}/tests/data/console_plan.golden`, 'utf8');
const golden = Uint8Array.from(Buffer.from(hex.replace(/\s/g, ''), 'hex'));

function decoded(bytes, piece) {
  const plan = new PlanDecoder();
  for (let at = 0; at < bytes.length; at += piece) plan.push(bytes.subarray(at, at + piece));
  return plan;
}

for (const piece of [1, 3, 7, 1000, 2077, 1 << 20]) {
  const plan = decoded(golden, piece);
  expect(plan.isWhole && plan.count === 40, `whole, in pieces of ${piece}`);
  expect(plan.sizeMm.join() === '50,50,30', 'the size of the block');
  for (let i = 0; i < 40; ++i) {
    const at = plan.index[i];
    const mm = [0, 1, 2].map((axis) => plan.points[4 * at + axis] / 65535 * plan.sizeMm[axis]);
    const expected = [1.25 * i, 50 - 0.3 * i, i % 2 ? 2.6 : 2.5];
    expect(mm.every((value, axis) => Math.abs(value - expected[axis]) < 50 / 65535),
           `point ${i}: ${mm}`);
    const cell = mm.map((value, axis) => Math.min(7, Math.floor(value / plan.sizeMm[axis] * 8)));
    const number = cell[0] * 64 + cell[1] * 8 + cell[2];
    expect(plan.starts[number] <= at && at < plan.starts[number + 1], `cell of point ${i}`);
  }
}
const most = golden.subarray(0, golden.length - 1);
expect(decoded(most, 64).hasPoints && !decoded(most, 64).isWhole, 'cut off');
for (const at of [0, 24 + 4 * 512, 2076 + 8 * 40 + 1]) {
  const broken = golden.slice();
  broken[at] = 255;
  fails(() => decoded(broken, 64), `broken at ${at}`);
}
fails(() => decoded(Uint8Array.from([...golden, 0]), 64), 'too long');

// Normalized numbers, 1 byte or a multiple of 4 of each point, or floats: what a graphics card
// reads as it is. Of others its driver keeps a second copy.
const cloud = new Cloud(decoded(golden, 1000));
cloud.takeChannels(new Uint8Array(40).fill(2).buffer);
cloud.take(Uint32Array.from([1, 3 + 2 ** 29]).buffer);
const geometries = cloud.group.children.map((child) => child.geometry)
  .filter((geometry) => geometry.attributes.outcome);
expect(geometries.length > 2, 'cells and what was made');
for (const { attributes } of geometries) {
  expect(Object.keys(attributes).sort().join() === 'channel,outcome,position',
         `numbers of a point: ${Object.keys(attributes)}`);
  for (const [name, { array, itemSize, normalized }] of Object.entries(attributes)) {
    const bytes = itemSize * (array?.BYTES_PER_ELEMENT ?? 0);
    expect(array instanceof Float32Array || normalized && (bytes === 1 || bytes % 4 === 0),
           `${name}: ${itemSize} of ${array?.constructor.name}`);
  }
}

// Cells of different sizes; none of every third is in view.
const starts = new Uint32Array(513);
for (let cell = 0; cell < 512; ++cell) starts[cell + 1] = starts[cell] + (cell * 37) % 2000;
const seen = Array.from({ length: 512 }, (_, cell) => cell % 3 !== 0);
const picture = new Picture(starts);
expect(!picture.isWhole, 'a picture that was not begun is not whole');
for (const round of [0, 1]) {
  const times = new Uint8Array(starts[512]);
  picture.clear(seen);
  let frames = 0;
  while (!picture.isWhole && frames < 1000) {
    const added = picture.add(20000, (cell, first, count) => {
      expect(seen[cell], 'a cell out of view');
      times.subarray(first, first + count).forEach((_, i) => ++times[first + i]);
    });
    expect(added <= 20000 + 512, 'no more than the budget and a point of each cell');
    ++frames;
    const shares = [...picture.drawn].map((drawn, cell) => drawn / picture.size(cell))
      .filter((_, cell) => seen[cell] && picture.size(cell) > 1000);
    expect(Math.max(...shares) - Math.min(...shares) < 1 / 1000, 'the same share of each cell');
  }
  let wrong = 0;
  for (let cell = 0; cell < 512; ++cell) {
    for (let i = starts[cell]; i < starts[cell + 1]; ++i) wrong += times[i] !== (seen[cell] ? 1 : 0);
  }
  expect(wrong === 0, `round ${round}: every point in view once, ${wrong} are not`);
  expect(frames > 10 && frames < 20, `${frames} frames`);
}
picture.clear(seen.map(() => false));
expect(picture.isWhole, 'nothing in view is whole');

// From afar every cell is in view; the cells in view are those with a point in the picture.
const far = { around: 0.3, above: 0.2, distance: 4 };
expect(cellsInView([1, 1, 0.6], far, 1.5).every(Boolean), 'all from afar');
const near = { around: 2, above: -0.7, distance: 0.5 };
const sides = [1, 0.8, 0.6];
const inView = cellsInView(sides, near, 1.2);
expect(inView.filter(Boolean).length < 400, 'some are out of view from near');
const tangent = Math.tan(Math.PI / 8);
for (let cell = 0; cell < 512; ++cell) {
  for (let i = 0; i < 64; ++i) {
    const inside = [i >> 4, i >> 2 & 3, i & 3];
    const [x, y, z] = [cell >> 6, cell >> 3 & 7, cell & 7]
      .map((step, axis) => ((step + inside[axis] / 3) / 8 - 0.5) * sides[axis]);
    const [ca, sa, cb, sb] = [Math.cos(2), Math.sin(2), Math.cos(-0.7), Math.sin(-0.7)];
    const depth = 0.5 - (x * ca * cb + y * sa * cb + z * sb);
    const across = -x * sa + y * ca;
    const high = -x * ca * sb - y * sa * sb + z * cb;
    const visible = depth > 0 && Math.abs(across) < depth * tangent * 1.2 &&
      Math.abs(high) < depth * tangent;
    expect(!visible || inView[cell], `cell ${cell} has a point in the picture`);
  }
}

// Ticks count from the first pulse, over a counter of 32 bits, and go on behind those of the
// power-up before.
const ticks = new Ticks(10);
const sent = (...numbers) => Uint32Array.from(numbers).buffer;
expect(ticks.take(sent(5, 0xffffffff, 0, 3, 0xfffffffe, 4, 2)) && ticks.next === 5, 'more ticks');
expect(ticks.take(sent(8, 2, 12, 0xffffffff, 0, 0, 1000, 1, 1003)), 'ticks of another power-up');
expect(!ticks.take(sent(8)), 'no more ticks');
expect([...ticks.of].join() === '15,18,14,0,4,0,0,0,0,0' && ticks.last === 18, `ticks ${ticks.of}`);

const budget = new FrameBudget();
for (let i = 0; i < 100; ++i) budget.follow(200, true);
expect(budget.points === 20000, 'never below 20000 points');
for (let i = 0; i < 10; ++i) budget.follow(40, true);
expect(budget.points === 20000, '20 to 30 frames a second are kept');
for (let i = 0; i < 10; ++i) budget.follow(16, false);
expect(budget.points === 20000, 'a frame with few points shows nothing of more');
for (let i = 0; i < 100; ++i) budget.follow(16, true);
expect(budget.points === 4e6, 'more points for a fast machine, up to a limit');

async function checkQueueLines() {
  // What the texts ask a browser for.
  globalThis.navigator = { languages: ['en'] };
  globalThis.HTMLElement = class {};
  const { aboutByCell, duration, queueLines } = await import('../../services/console/page/queue_time');
  const queue = { cell: 'left', jobs: 3, unknown_jobs: 1, left_s: 4350 };
  const noon = new Date(2026, 0, 2, 12);
  const lines = (end, more = {}) =>
    queueLines([{ ...queue, ends_utc: end.toISOString(), ...more }], noon);
  expect(duration(4350) === '1 h 12 min' && duration(75) === '1 min 15 s', 'a duration');
  const today = lines(new Date(2026, 0, 2, 13, 12));
  expect(today.length === 2 && /^left: 2 jobs take 1 h 12 min, until 01:12.PM or later$/
    .test(today[0]), today[0]);
  expect(today[1] === 'left: the time of 1 job is not known yet', today[1]);
  const tomorrow = lines(new Date(2026, 0, 3, 1, 12), { unknown_jobs: 0 });
  expect(tomorrow.length === 1 && tomorrow[0].includes('until Jan 3'), tomorrow[0]);
  const about = aboutByCell([{ uid: 'a', cell: 'left' }, { uid: 'b', cell: 'right' }],
    [{ uid: 'a', time_s: 75 }, { uid: 'gone', time_s: 9 }]);
  const estimated = queueLines([{ ...queue, ends_utc: noon.toISOString() }], noon, about);
  expect(estimated[1] === 'left: about 1 min 15 s more for 1 job whose points are not made yet' &&
         estimated.length === 2, estimated.join());
  const unknown = queueLines([{ cell: 'right', jobs: 2, unknown_jobs: 2, left_s: 0,
    ends_utc: '' }], noon);
  expect(unknown.join() === 'right: the time of 2 jobs is not known yet', unknown.join());
}

// What is not known is not shown as if it were: a stop that nobody reads is not released.
async function checkMachineStates() {
  const { machineState } = await import('../../services/console/page/machine_state');
  const good = { laser_line_up: true, motion_line_up: true, lamp: 'warm', key_on: true,
    door_closed: true, stop_released: true, stops_held: [] };
  const shows = (change, line) => {
    const shown = machineState({ ...good, ...change });
    expect(shown === line, `machine: ${shown}`);
  };
  shows({}, 'lamp warm, key on, door closed, stop released');
  shows({ stop_released: false },
        'lamp warm, key on, door closed, STOP of the machine pressed or latched');
  shows({ stops_held: ['a'] }, 'lamp warm, key on, door closed, STOP PRESSED');
  shows({ laser_line_up: false, key_on: false, door_closed: false, stop_released: false },
        'LASER LINE DOWN');
  shows({ motion_line_up: false },
        'lamp warm, key on, door closed, stop released, MOTION LINE DOWN');
  shows({ one_line: true, lamp: 'none' }, 'key on, door closed, stop released');
  shows({ one_line: true, laser_line_up: false, motion_line_up: false }, 'LINE DOWN');
  // Nobody is sent to look for a cable.
  shows({ other_version: true, laser_line_up: false, motion_line_up: false },
        'OTHER VERSION, its state is not understood here');
}

checkQueueLines().then(checkMachineStates).then(() => {
  console.log(failed ? `${failed} failed`
    : 'decoder, cells, budget, queues and machines are right');
  process.exit(failed ? 1 : 0);
});
