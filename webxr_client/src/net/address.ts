/** Place in the page's address: frame, label and camera beside the recording. */

/** Eye, then a point that it looks at; room coordinates, metres. */
export type View = readonly [number, number, number, number, number, number];

export interface Place {
  readonly frame: number;
  /** The active label; 0: none. */
  readonly label: number;
  readonly view: View | null;
}

const NAMES = ['frame', 'label', 'view'] as const;
const DIGITS = 3;

function count(text: string | null): number {
  return text !== null && /^\d{1,9}$/.test(text) ? Number(text) : 0;
}

/** Return the place in an address; invalid parts count as missing. */
export function placeIn(search: string): Place {
  const query = new URLSearchParams(search);
  const view = (query.get('view') ?? '').split(',').map(Number);
  const whole = view.length === 6 && view.every(Number.isFinite);
  return {
    frame: count(query.get('frame')),
    label: count(query.get('label')),
    view: whole ? (view as unknown as View) : null,
  };
}

/** The address with another place. */
export function withPlace(address: string, { frame, label, view }: Place): string {
  const url = new URL(address);
  forgetPlace(url);
  url.searchParams.set('frame', String(frame));
  if (label !== 0) url.searchParams.set('label', String(label));
  const query = url.search;
  // Commas need no escape, and the address is read by people.
  const numbers = view?.map((value) => Number(value.toFixed(DIGITS))).join(',');
  return url.href.replace(query, query + (numbers === undefined ? '' : `&view=${numbers}`));
}

/** Take the place out of an address. */
export function forgetPlace(url: URL): void {
  for (const name of NAMES) url.searchParams.delete(name);
}
