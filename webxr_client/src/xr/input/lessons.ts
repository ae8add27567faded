/** Lessons: text, position and number of uses of each button's action; learnt ones are hidden. */
import { computed, signal } from '@preact/signals';
import { doubtfulFrames } from '../../store/cells';
import { canEdit, isStroke, state } from '../../store/state';
import { keep, keptJson } from '../../store/kept';
import { Listeners } from '../../store/listeners';
import { peek } from '../../store/watch';
import { chords, type Device } from './devices';
import type { Spot } from './kind';

export type Lesson = 'paint' | 'object' | 'step' | 'play' | 'size' | 'grab' | 'erase' | 'undo' | 'teleport' | 'turn' | 'panel' | 'redo' | 'doubt' | 'label'; // prettier-ignore

/** Task of a controller: it paints, or it helps. */
export type Part = 'brush' | 'other';

const KEY = 'pointbrush.lessons';

/** The only lesson that hints teach now; null: all that are possible. */
export const taught = signal<Lesson | null>(null);

export interface Tip {
  /** The control and its action: `Grip + Pad ↑: eraser`. */
  readonly text: string;
  /** The same beside the control itself: `Grip + ↑ eraser`. */
  readonly short: string;
  readonly lesson: Lesson;
  readonly spot: Spot;
}

/** The words for a device with a part, in the left or the right hand, the most needed ones first. */
export function tipsFor(device: Device, part: Part, left: boolean): Tip[] {
  const paints = part === 'brush';
  if (device.pad === 'none') return [onlyTip(device.id === 'hand' ? 'Pinch' : 'Trigger', paints)];
  const pad = padName(device);
  const buttons = buttonTips(device, part, left);
  const moves = device.squeeze >= 0 ? 'Grip' : paints ? '' : 'Trigger';
  const grab = moves ? [tip(moves === 'Grip' ? 'squeeze' : 'trigger', moves, '', 'move the room', 'grab')] : []; // prettier-ignore
  if (!paints) return [...buttons, ...otherTips(pad), ...grab];
  const size = chords(device) ? [tip('pad', `Grip + ${pad}`, '→ ↓', 'size', 'size')] : [];
  return [...paintingTips(pad), ...buttons, ...grab, ...size];
} // prettier-ignore

/** The thumb does `how`; without it the control is pressed. */
function tip(spot: Spot, control: string, how: string, act: string, lesson: Lesson): Tip {
  const grip = control.startsWith('Grip +') ? 'Grip + ' : '';
  const text = `${control} ${how}`.trim() + `: ${act}`;
  if (control === 'Pinch') return { text, short: text, lesson, spot };
  const short = how === 'pressed' ? `press: ${act}` : `${grip}${how} ${act}`.trim();
  return { text, short, lesson, spot };
}

/** Actions of the two buttons, by the hand's part. */
const ACTS = {
  brush: [['eraser', 'erase'], ['undo', 'undo']],
  other: [['timeline', 'panel'], ['redo', 'redo']],
} as const; // prettier-ignore

/** The words of the buttons, or of the chords that stand in for them. */
function buttonTips(device: Device, part: Part, left: boolean): Tip[] {
  const side = left ? 1 : 0;
  const buttons = [
    ['primary', device.primary, device.primaryName[side], '↑'],
    ['secondary', device.secondary, device.secondaryName[side], '←'],
  ] as const;
  return buttons.flatMap(([spot, button, name, arrow], i) => {
    const [act, lesson] = ACTS[part][i]!;
    if (button >= 0) return tip(spot, name, '', act, lesson);
    return chords(device) ? tip('pad', `Grip + ${padName(device)}`, arrow, act, lesson) : [];
  });
}

function onlyTip(control: string, paints: boolean): Tip {
  const [act, lesson] = paints ? (['paint', 'paint'] as const) : (['move the room', 'grab'] as const);
  return tip('trigger', control, '', act, lesson);
} // prettier-ignore

/** The name of a controller's pad in words for a person. */
export function padName({ pad }: Device): string {
  return pad === 'touchpad' ? 'Pad' : 'Stick';
}

function paintingTips(pad: string): Tip[] {
  return [
    tip('trigger', 'Trigger', '', 'paint', 'paint'),
    tip('pad', pad, '↑ ↓', 'labels', 'label'),
    tip('pad', pad, '← →', 'frames', 'step'),
    tip('pad', pad, 'pressed', 'play', 'play'),
    tip('pad', `Trigger + ${pad}`, '↑', 'object', 'object'),
  ];
}

function otherTips(pad: string): Tip[] {
  return [
    tip('pad', pad, '↑', 'go there', 'teleport'),
    tip('pad', pad, '← →', 'turn', 'turn'),
    tip('pad', pad, 'pressed', 'doubtful', 'doubt'),
  ];
}

const doubtful = computed(() => {
  const { rows } = state.timeline.value;
  return doubtfulFrames(rows.values(), state.sequence.value?.frames ?? 0).length > 0;
});
const strokes = (): boolean => peek(canEdit) && isStroke(peek(state.tool));
const moves = (): boolean => (peek(state.sequence)?.frames ?? 0) > 1;
const painted = (): boolean => peek(state.undo) !== null;

/** Conditions of actions that do nothing at times. */
const CONDITIONS: Partial<Record<Lesson, () => boolean>> = {
  paint: strokes,
  size: strokes,
  // The sign at the brush tells of it.
  object: () => false,
  label: () => peek(state.palette).length > 1,
  step: moves,
  play: moves,
  erase: painted,
  undo: painted,
  redo: () => peek(state.redo) !== null,
  doubt: () => peek(doubtful),
};

/** Whether an action would do anything now. */
export function possible(lesson: Lesson): boolean {
  return CONDITIONS[lesson]?.() ?? true;
}

/** Actions that were done by a button, on each device; kept in the browser. */
export class Lessons {
  /** Told every use of a button. */
  readonly uses = new Listeners<Lesson>();
  private readonly learnt = new Map(load());

  markDone(lesson: Lesson, { id }: Device): void {
    this.uses.run(lesson);
    const learnt = this.learnt.get(id) ?? new Set();
    if (learnt.has(lesson)) return;
    this.learnt.set(id, learnt.add(lesson));
    const lessons = [...this.learnt].map(([device, learnt]) => [device, [...learnt]]);
    keep(KEY, JSON.stringify(lessons));
  }

  /** Whether a hint helps now: its action is possible and was never done, or is the one that is taught. */
  wants(lesson: Lesson, { id }: Device): boolean {
    const only = peek(taught);
    if (only !== null) return lesson === only;
    return this.learnt.get(id)?.has(lesson) !== true && possible(lesson);
  }
}

function load(): [string, Set<string>][] {
  const known = keptJson(KEY);
  if (!Array.isArray(known)) return [];
  return (known as [string, string[]][]).map(([device, lessons]) => [device, new Set(lessons)]);
}
