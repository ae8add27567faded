/** Numbers as people read them. */

const THIN_SPACE = '\u202f';

/** 1234567 → "1 234 567" with thin spaces, at which no line ends. */
export function count(value: number): string {
  return String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, THIN_SPACE);
}

/** 217088 → "217 k", 1234567 → "1.23 M"; for places where a full number does not fit. */
export function shortCount(value: number): string {
  if (value < 10_000) return count(value);
  if (value < 999_500) return `${Math.round(value / 1000)}${THIN_SPACE}k`;
  return `${(value / 1e6).toFixed(value < 1e7 ? 2 : 1)}${THIN_SPACE}M`;
}

/** 0.05 → "5.0 cm", 1.5 → "1.50 m". */
export function metres(value: number): string {
  if (value < 0.995) {
    const centimetres = value * 100;
    return `${centimetres.toFixed(centimetres < 9.95 ? 1 : 0)} cm`;
  }
  return `${value.toFixed(value < 9.995 ? 2 : 1)} m`;
}

/** 83.4 → "1:23.40". */
export function clock(seconds: number): string {
  const hundredths = Math.round(Math.max(0, seconds) * 100);
  const minutes = Math.floor(hundredths / 6000);
  const rest = ((hundredths - minutes * 6000) / 100).toFixed(2);
  return `${minutes}:${rest.padStart(5, '0')}`;
}

export function percent(share: number): string {
  return `${Math.round(share * 100)} %`;
}

/** 2 plus "frame" → "2 frames". */
export function plural(value: number, noun: string): string {
  return `${count(value)} ${noun}${value === 1 ? '' : 's'}`;
}

export function bytes(value: number): string {
  if (value < 1e6) return `${Math.round(value / 1e3)} kB`;
  if (value < 1e9) return `${(value / 1e6).toFixed(1)} MB`;
  return `${(value / 1e9).toFixed(2)} GB`;
}

const days = new Intl.DateTimeFormat(undefined, { dateStyle: 'medium' });

/** A date as people write it here, from one as the server writes it. */
export function day(iso: string): string {
  return days.format(new Date(iso));
}

const DAY_MS = 86_400_000;
const times = new Intl.RelativeTimeFormat('en', { numeric: 'auto' });

/** Time since a date of the last week as "5 minutes ago"; of an earlier one the day. */
export function ago(iso: string): string {
  const past = Date.now() - Date.parse(iso);
  if (past > 7 * DAY_MS) return day(iso);
  if (past > DAY_MS) return times.format(-Math.round(past / DAY_MS), 'day');
  const minutes = Math.round(past / 60_000);
  if (minutes < 1) return 'just now';
  return minutes < 60 ? times.format(-minutes, 'minute') : times.format(-Math.round(minutes / 60), 'hour'); // prettier-ignore
}
