/** Moving through time: play, step, seek, the next frame that wants a look. */
import { actions, type Actions } from '../actions';
import { frameRange, ordered } from '../panels/range';
import { cellKind, nextUnlabelled, wantsLook } from '../panels/timeline-layout';
import { notify, state } from '../state';
import type { Playback } from './playback';

type TimeActions = Pick<
  Actions,
  | 'nextUnlabelled'
  | 'setIn'
  | 'setOut'
  | 'togglePlay'
  | 'play'
  | 'pause'
  | 'step'
  | 'seek'
  | 'setSpeed'
  | 'toggleLoop'
  | 'nextDoubtful'
>;

const FASTEST = 16;

export function timeActions(playback: Playback): TimeActions {
  return {
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
      if (frame === null) notify('info', 'Every other frame has labels');
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
      actions.goToObject(found.label, found.frame);
    },
  };
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
  for (let away = 1; away <= frames; away++) {
    const frame = wrapped(state.frame.peek() + away * direction, frames);
    const doubt = rows.find(([, row]) => wantsLook(cellKind(row, frame)));
    if (doubt) return { frame, label: doubt[0] };
  }
  return null;
}
