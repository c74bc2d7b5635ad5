// How long work takes yet, as people read it; the shop computes it.
import { Dict } from './dom';
import { fill, fillCounted, language, text } from './text';

export function duration(seconds: number): string {
  const whole = Math.max(0, Math.round(seconds));
  const minutes = Math.floor(whole / 60);
  if (minutes >= 60)
    return fill(text.hours, { hours: Math.floor(minutes / 60), minutes: minutes % 60 });
  return minutes
    ? fill(text.minutes, { minutes, seconds: whole % 60 })
    : fill(text.seconds, { seconds: whole });
}

/** The time of day by the clock of this computer, with its date when it is another day. */
function clock(time: Date, now: Date): string {
  const date = time.toDateString() === now.toDateString()
    ? {} : { month: 'short', day: 'numeric' } as const;
  return time.toLocaleString(language, { ...date, hour: '2-digit', minute: '2-digit' });
}

/** For each machine how long its jobs take, and of how many that is not known. */
export function queueLines(queues: Dict[], now = new Date()): string[] {
  return queues.flatMap(({ cell, jobs, unknown_jobs: unknown, left_s, ends_utc }) => {
    const known = jobs - unknown;
    return [
      ...known ? [fillCounted(text.queueTime, known, {
        cell, known, time: duration(left_s), clock: clock(new Date(ends_utc), now) })] : [],
      ...unknown ? [fillCounted(text.queueUnknown, unknown, { cell, unknown })] : [],
    ];
  });
}
