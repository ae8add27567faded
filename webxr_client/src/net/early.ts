/** What goes out before the rest of the page has come: the socket, and which recording to open. */
import { Link } from './link';
import { api } from './rest';

/** A recording as the list has it. */
export interface SequenceOut {
  readonly id: string;
  readonly name: string;
  readonly frames: number;
  readonly fps: number;
  readonly points: readonly number[];
  readonly damaged: string | null;
}

export class Early {
  readonly link = new Link();
  /** The recording that was asked for; null where the page has to show the list, or an error. */
  readonly opening: Promise<string | null>;
  /** The address has a token still: the server did not take it. */
  readonly refused = new URLSearchParams(location.search).has('token');

  constructor() {
    if (this.refused) {
      this.opening = Promise.resolve(null);
      return;
    }
    this.link.connect();
    this.opening = this.open().catch(() => null);
  }

  private async open(): Promise<string | null> {
    const id = firstOf(await listSequences());
    if (id !== null) {
      nameInAddress(id);
      this.link.open({ type: 'open', sequence: id, frame: 0, revision: null });
    }
    return id;
  }
}

export function listSequences(): Promise<SequenceOut[]> {
  return api('GET', 'sequences');
}

/** The recording that the address names, or the only one there is. */
export function firstOf(list: readonly { readonly id: string }[]): string | null {
  const wanted = new URLSearchParams(location.search).get('sequence');
  if (list.some(({ id }) => id === wanted)) return wanted;
  return list.length === 1 ? list[0]!.id : null;
}

/** Reloading the page opens the same recording again, or the list of them (null). */
export function nameInAddress(id: string | null): void {
  const url = new URL(location.href);
  if (id === null) url.searchParams.delete('sequence');
  else url.searchParams.set('sequence', id);
  history.replaceState(null, '', url);
}
