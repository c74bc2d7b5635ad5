// What is known of a machine now, in one line: what a controller does not report is not shown.
import { Dict } from './dom';
import { fill, text } from './text';

function stopText(machine: Dict): string {
  if (machine.stops_held?.length) return text.stopPressed;
  return machine.stop_released ? text.stopReleased : text.stopAtMachine;
}

/** Of a machine of ShopStatus. */
export function machineState(machine: Dict): string {
  if (machine.other_version) return text.otherVersion;
  const parts: string[] = [];
  if (machine.laser_line_up) {
    if (!machine.one_line) parts.push(fill(text.lamp, { lamp: machine.lamp }));
    parts.push(machine.key_on ? text.keyOn : text.keyOff,
      machine.door_closed ? text.doorClosed : text.doorOpen, stopText(machine));
    if (machine.open_input) parts.push(machine.open_input);
    if (machine.outputs_on) parts.push(machine.outputs_on);
  } else {
    parts.push(machine.one_line ? text.lineDown : text.laserLineDown);
    if (machine.stops_held?.length) parts.push(text.stopPressed);
  }
  if (!machine.one_line && !machine.motion_line_up) parts.push(text.motionLineDown);
  return parts.join(', ');
}
