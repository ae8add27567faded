/** Shows the labels of a copy, or where two differ, over the frame on screen. */
import { OTHERS } from '../cloud/picture/palette';
import type { CloudFrame } from '../cloud/points/frame';
import type { Engine } from '../engine/engine';
import { attempt, sequencePath } from '../engine/recordings/recordings';
import { api, apiBytes } from '../net/rest';
import type { Label } from '../protocol/messages';
import { state } from '../store/state';
import { theme } from '../store/theme';
import { watch } from '../store/watch';
import { pair, type Shows, shows } from './copies';
import { coloursOf, type Copy, idsOf, labelsOf } from './shown-copies';

/** Frames come one after the other: the server is asked once they rest, milliseconds. */
const REST_MS = 120;
const OVERLAY = 'compared';

export class Compared {
  private timer: ReturnType<typeof setTimeout> | undefined;
  /** Copies as they were when their people were compared. */
  private known = new WeakMap<CloudFrame, readonly [Copy, Copy]>();
  private request: AbortController | null = null;

  constructor(private readonly engine: Engine) {
    watch([pair], () => (this.known = new WeakMap()));
    watch([shows, pair, state.shown, state.playing, state.palette, theme], () => this.ask());
  }

  private ask(): void {
    clearTimeout(this.timer);
    this.request?.abort();
    const frame = this.engine.frame();
    const what = shows.peek();
    if (what === 'recording' || !pair.peek()) {
      this.drop();
      return;
    }
    if (!frame?.complete || frame.large || state.playing.peek()) return;
    const comparison = this.known.get(frame);
    if (comparison) this.show(frame, comparison, what);
    else this.timer = setTimeout(() => void this.fetch(frame), REST_MS);
  }

  private async fetch(frame: CloudFrame): Promise<void> {
    const between = pair.peek();
    if (!between) return;
    const { signal } = (this.request = new AbortController());
    const copy = async (id: string): Promise<Copy> => {
      const path = `${sequencePath(id)}/frames/${frame.index}/annotation?order=stored`;
      const labels = labelsOf(await apiBytes('GET', path, undefined, signal));
      return { labels, palette: await api<readonly Label[]>('GET', `${sequencePath(id)}/labels`) };
    };
    await attempt('The copies did not load', async () => {
      try {
        const copies = await Promise.all([copy(between.first), copy(between.second)]);
        if (pair.peek() !== between) return;
        this.known.set(frame, copies);
        this.ask();
      } catch (error) {
        if (!signal.aborted) throw error;
      }
    });
  }

  private show(frame: CloudFrame, [first, second]: readonly [Copy, Copy], what: Shows): void {
    const { palette } = this.engine.viewer;
    const own = state.palette.peek();
    palette.setOthers(coloursOf(first.palette, second.palette, own, theme.peek()));
    const values = idsOf(first, second, own, what, OTHERS);
    const indices = Uint32Array.from(values, (_, k) => k);
    frame.setOverlay(OVERLAY, { indices, values });
    if (frame === this.engine.frame()) this.engine.viewer.show(frame);
  }

  private drop(): void {
    const shown = this.engine.frame();
    for (const frame of this.engine.playback.store.all()) {
      if (frame.dropOverlay(OVERLAY) && frame === shown) this.engine.viewer.show(frame);
    }
  }
}
