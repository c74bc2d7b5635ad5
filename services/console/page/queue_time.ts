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

/** Estimates of jobs that are not planned yet, of each machine: how many, and of all together. */
export function aboutByCell(jobs: Dict[], about: Dict[]): Record<string, Dict> {
  const cells: Record<string, Dict> = {};
  for (const { uid, time_s } of about) {
    const cell = jobs.find((job) => job.uid === uid)?.cell;
    if (cell === undefined) continue;
    const sum = (cells[cell] ??= { jobs: 0, time_s: 0 });
    sum.jobs += 1;
    sum.time_s += time_s;
  }
  return cells;
}

/** For each machine how long its jobs take, about how long those that are not planned yet, and of
 * how many that is not known. */
export function queueLines(queues: Dict[], now = new Date(),
                           about: Record<string, Dict> = {}): string[] {
  return queues.flatMap(({ cell, jobs, unknown_jobs, left_s, ends_utc }) => {
    const known = jobs - unknown_jobs;
    const estimated = Math.min(about[cell]?.jobs ?? 0, unknown_jobs);
    const unknown = unknown_jobs - estimated;
    return [
      ...known ? [fillCounted(text.queueTime, known, {
        cell, known, time: duration(left_s), clock: clock(new Date(ends_utc), now) })] : [],
      ...estimated ? [fillCounted(text.queueAbout, estimated, {
        cell, jobs: estimated, time: duration(about[cell].time_s) })] : [],
      ...unknown ? [fillCounted(text.queueUnknown, unknown, { cell, unknown })] : [],
    ];
  });
}
