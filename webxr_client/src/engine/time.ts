/** Moving through time: play, step, seek, the next doubtful frame, and the frame of an undo. */
import { actions, type ActionParts } from '../store/actions';
import { api } from '../net/rest';
import type { PastEdit } from '../protocol/values';
import { frameRange, ordered } from '../store/range';
import { cellKind, nextUnlabelled, wantsLook } from '../store/cells';
import { notify, state } from '../store/state';
import { follow } from '../store/watch';
import type { Playback } from './playback';
import { sequencePath } from './recordings/recordings';

const FASTEST = 16;

export function timeActions(playback: Playback) {
  return {
    time: {
      togglePlay: () => (state.playing.peek() ? playback.pause() : playback.play()),
      play: () => playback.play(),
      pause: () => playback.pause(),
      step: (frames) => {
        const info = state.sequence.peek();
        if (!info) return;
        playback.pause();
        playback.seek(wrapped(state.frame.peek() + frames, info.frames));
      },
      seek: (frame) => playback.seek(frame),
      setSpeed: (speed) => {
        state.speed.value = Math.min(FASTEST, Math.max(-FASTEST, speed));
        playback.restart();
      },
      toggleLoop: () => {
        state.loop.value = !state.loop.peek();
        playback.restart();
      },
      nextUnlabelled: (direction) => {
        const rows = [...state.timeline.peek().rows.values()];
        const frames = state.sequence.peek()?.frames ?? 0;
        const frame = nextUnlabelled(rows, state.frame.peek(), frames, direction);
        if (frame === null) notify('info', 'All other frames have labels');
        else {
          playback.pause();
          playback.seek(frame);
        }
      },
      setIn: () => setEdge('from'),
      setOut: () => setEdge('to'),
      nextDoubtful: (direction) => {
        const found = doubtful(direction);
        if (!found) {
          notify('info', 'No doubtful frames');
          return;
        }
        playback.pause();
        playback.seek(found.frame);
        actions.view.goToObject(found.label, found.frame);
      },
    },
  } satisfies ActionParts;
}

/** Set one end of the chosen stretch here; the other one stays, or is the recording's. */
function setEdge(edge: 'from' | 'to'): void {
  const frame = state.frame.peek();
  const range = frameRange.peek();
  const [first, last] = range ? ordered(range) : [0, (state.sequence.peek()?.frames ?? 1) - 1];
  frameRange.value =
    edge === 'from'
      ? { from: frame, to: Math.max(frame, last) }
      : { from: Math.min(first, frame), to: frame };
}

function wrapped(frame: number, frames: number): number {
  return ((frame % frames) + frames) % frames;
}

/** The nearest frame in a direction where some label's track is unsure, lost or hidden. */
function doubtful(direction: 1 | -1): { frame: number; label: number } | null {
  const frames = state.sequence.peek()?.frames ?? 0;
  const rows = [...state.timeline.peek().rows];
  for (let offset = 1; offset <= frames; offset++) {
    const frame = wrapped(state.frame.peek() + offset * direction, frames);
    const doubt = rows.find(([, row]) => wantsLook(cellKind(row, frame)));
    if (doubt) return { frame, label: doubt[0] };
  }
  return null;
}

/** Answers of an undo after this time are ignored, because the user has moved on. */
const PATIENCE_MS = 5000;
/** Number of newest edits that are searched for it. */
const RECENT = 20;
const WORDS = { undo: 'Undone', redo: 'Redone' } as const;

/** Go to the frame that an undo or redo changed after its answer, unless it is on screen. */
export function showTravel(type: 'undo' | 'redo', edit: string): void {
  const { id } = state.sequence.peek() ?? {};
  if (id === undefined) return;
  let waits = true;
  const stop = follow(() => {
    if (state.pending.value > 0 || !waits) return;
    waits = false;
    queueMicrotask(() => {
      stop();
      clearTimeout(timer);
      void find(id, edit).then((entry) => entry && go(type, entry));
    });
  });
  const timer = setTimeout(stop, PATIENCE_MS);
}

async function find(sequence: string, edit: string): Promise<PastEdit | null> {
  const path = `${sequencePath(sequence)}/edits?limit=${RECENT}`;
  // The user has not requested the history: an error needs no message.
  const edits = await api<PastEdit[]>('GET', path).catch(() => []);
  return edits.find((entry) => entry.id === edit) ?? null;
}

/** Go to the nearest frame of an edit, and show a message. */
function go(type: 'undo' | 'redo', { frames, summary }: PastEdit): void {
  const current = state.frame.peek();
  if (frames.length === 0 || frames.includes(current)) return;
  const distance = (frame: number): number => Math.abs(frame - current);
  const frame = frames.reduce((best, other) => (distance(other) < distance(best) ? other : best));
  actions.time.pause();
  actions.time.seek(frame);
  const label = labelIn(summary);
  if (label !== null) actions.view.goToObject(label, frame);
  notify('info', `${WORDS[type]} in frame ${frame}`, summary);
}

/** The label that a summary names, or null. */
export function labelIn(summary: string): number | null {
  const named = state.palette.peek().filter(({ name }) => summary.includes(name));
  // If both "pin" and "pin 1" occur, the longer name is meant.
  const [longest] = named.sort((a, b) => b.name.length - a.name.length);
  return longest?.id ?? null;
}
