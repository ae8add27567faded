/** First messages, before the rest of the page has come: the socket, and the recording to open. */
import type { Manifest } from '../protocol/values';
import { choosesRecording, isCheck, studyCode } from '../common/checking';
import { forgetPlace, placeIn } from './address';
import { Link } from './link';
import { api } from './rest';

export class Early {
  readonly link = new Link();
  /** The requested recording; null if the page has to show the list, or an error. */
  readonly opening: Promise<string | null>;
  /** The recording that the address names where there is none of that id, or null. */
  missing: string | null = null;
  /** The address has a token still: the server did not take it. */
  readonly refused = new URLSearchParams(location.search).has('token');

  constructor() {
    // The code of a participant opens the server first.
    if (this.refused || studyCode() !== null) {
      this.opening = Promise.resolve(null);
      return;
    }
    this.link.connect();
    this.opening = this.open().catch(() => null);
  }

  private async open(): Promise<string | null> {
    if (isCheck()) return null;
    const list = await listSequences();
    const id = firstOf(list);
    const wanted = new URLSearchParams(location.search).get('sequence');
    if (id !== wanted) this.missing = wanted;
    if (id !== null) {
      nameInAddress(id);
      const frames = list.find((row) => row.id === id)?.frames ?? 1;
      const frame = Math.min(placeIn(location.search).frame, Math.max(0, frames - 1));
      const message = { type: 'open', sequence: id, frame, revision: null } as const;
      this.link.post({ t: 'open', message });
    }
    return id;
  }
}

/** Fetch all recordings that the user may open, including copies (see `copy_of`). */
export function listSequences(): Promise<Manifest[]> {
  return api('GET', 'sequences?copies=true');
}

/** The recording that the address names; where it names none, the only one there is; none for a check. */
export function firstOf(
  list: readonly { readonly id: string; readonly copy_of?: string | null }[],
): string | null {
  if (choosesRecording()) return null;
  const wanted = new URLSearchParams(location.search).get('sequence');
  if (list.some(({ id }) => id === wanted)) return wanted;
  const whole = list.filter(({ copy_of: original }) => !original);
  return wanted === null && whole.length === 1 ? whole[0]!.id : null;
}

/** Reloading the page opens the same recording again, or the list of them (null). */
export function nameInAddress(id: string | null): void {
  const url = new URL(location.href);
  if (id !== url.searchParams.get('sequence')) forgetPlace(url);
  if (id === null) url.searchParams.delete('sequence');
  else url.searchParams.set('sequence', id);
  history.replaceState(null, '', url);
}
