/** Overlays the frames around the one on screen while playback is paused: placements and display. */
import { Matrix4 } from 'three';
import { accumulation, leftOut, MOST_AROUND, placedFrames } from '../cloud/points/accumulation';
import type { PlacedFrame } from '../cloud/points/layer';
import type { Viewer } from '../cloud/picture/viewer';
import { api, ApiError } from '../net/rest';
import type { SequenceInfo } from '../protocol/messages';
import type { Placement } from '../protocol/values';
import { peek, watch } from '../store/watch';
import { notify, state } from '../store/state';
import type { Playback } from './playback';

/** Points of all frames together that one picture can hold. */
export const MOST_POINTS = 8_000_000;
/** Debounce of requests during stepping through frames, milliseconds. */
const REST_MS = 120;

/** Frames around `frame`, the nearest first, as many as fit; and how many do not. */
export function wanted(
  info: SequenceInfo,
  frame: number,
  before: number,
  after: number,
): { frames: number[]; left: number } {
  const frames: number[] = [];
  let points = info.points[frame] ?? 0;
  let left = 0;
  for (let distance = 1; distance <= Math.max(before, after); distance++) {
    for (const other of [frame + distance, frame - distance]) {
      const isInRange = other > frame ? distance <= after : distance <= before;
      const count = info.points[other] ?? 0;
      if (!isInRange || count === 0) continue;
      points += count;
      if (points <= MOST_POINTS) frames.push(other);
      else left += 1;
    }
  }
  return { frames, left };
}

/** A transform in source coordinates, row-major, as one of local coordinates (source − shift). */
export function localMatrix(rows: readonly number[], shift: readonly number[]): Matrix4 {
  const T = [...rows];
  for (let row = 0; row < 3; row++) {
    const turned = [0, 1, 2].reduce((sum, k) => sum + rows[row * 4 + k]! * shift[k]!, 0);
    T[row * 4 + 3]! += turned - shift[row]!;
  }
  return new Matrix4().set(...(T as Parameters<Matrix4['set']>));
}

export class Accumulated {
  /** Placements of frames over frame `over`, by their numbers. */
  private placements = new Map<number, Omit<PlacedFrame, 'frame'>>();
  private over = -1;
  private newestRequest = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly viewer: Viewer,
    private readonly playback: Playback,
  ) {
    playback.around = (frame) => this.around(frame);
    watch([accumulation], () => playback.lookAround());
    watch([accumulation, state.frame, state.playing, state.sequence], () => this.forget());
    // New or undone tracks change the placements of tracked objects.
    watch([state.timeline], () => this.scheduleRequest());
  }

  private get on(): boolean {
    const info = peek(state.sequence);
    return peek(accumulation).on && info !== null && !info.large && !peek(state.playing);
  }

  /** Frames that belong to one when it is shown. */
  private around(frame: number): number[] {
    const info = peek(state.sequence);
    if (!info || !this.on) return [];
    const { before, after } = peek(accumulation);
    const { frames, left } = wanted(info, frame, before, after);
    leftOut.value = left;
    return frames;
  }

  private forget(): void {
    this.newestRequest += 1;
    this.placements = new Map();
    if (!this.on) leftOut.value = 0;
    this.scheduleRequest();
  }

  private scheduleRequest(): void {
    clearTimeout(this.timer);
    if (this.on) this.timer = setTimeout(() => void this.ask(), REST_MS);
  }

  private async ask(): Promise<void> {
    const info = peek(state.sequence);
    if (!info || !this.on) return;
    const request = ++this.newestRequest;
    const over = peek(state.frame);
    const { before, after } = peek(accumulation);
    const most = (frames: number): number => Math.min(MOST_AROUND, frames);
    const query = `before=${most(before)}&after=${most(after)}`;
    const path = `sequences/${info.id}/frames/${over}/placements?${query}`;
    try {
      const found = await api<Placement[]>('GET', path);
      if (request !== this.newestRequest) return;
      this.placements = new Map(found.map((entry) => [entry.frame, placed(entry, info.shift)]));
      this.over = over;
      this.viewer.invalidate();
    } catch (error) {
      if (request !== this.newestRequest || !(error instanceof ApiError)) return;
      accumulation.value = { ...peek(accumulation), on: false };
      notify('error', 'The frames cannot be overlaid', error.message);
    }
  }

  /** Show newly loaded frames; called before each picture. */
  update(): void {
    const before = peek(placedFrames);
    const shown = this.playback.frame?.index ?? -1;
    const isShown = this.on && shown === this.over && shown === peek(state.frame);
    if (!isShown && before.length === 0) return;
    const frames = isShown ? this.loaded(shown, before) : [];
    const same = frames.length === before.length && frames.every((one, i) => one === before[i]);
    if (!same) placedFrames.value = frames;
    if (this.viewer.lay(frames)) this.viewer.invalidate();
  }

  private loaded(shown: number, before: readonly PlacedFrame[]): PlacedFrame[] {
    const frames: PlacedFrame[] = [];
    for (const number of this.around(shown)) {
      const frame = this.playback.store.get(number);
      const place = this.placements.get(number);
      if (!frame || frame.loaded === 0 || !place) continue;
      const known = before.find((one) => one.frame === frame && one.placed === place.placed);
      frames.push(known ?? { frame, ...place });
    }
    return frames;
  }
}

function placed(entry: Placement, shift: readonly number[]): Omit<PlacedFrame, 'frame'> {
  return {
    placed: localMatrix(entry.T_shown_frame, shift),
    moving: new Map(
      entry.moving.map(({ label, T_shown_frame }) => [label, localMatrix(T_shown_frame, shift)]),
    ),
  };
}
