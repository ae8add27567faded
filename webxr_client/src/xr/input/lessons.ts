/** Lessons: each button's action in words, and its uses, since what is learnt needs no words. */
import { Listeners } from '../../store/listeners';
import { chords, type Device } from './devices';

export type Lesson = 'paint' | 'step' | 'play' | 'size' | 'grab' | 'erase' | 'undo' | 'teleport' | 'turn' | 'panel' | 'redo' | 'doubt' | 'label'; // prettier-ignore

/** Task of a controller: it paints, or it helps. */
export type Part = 'brush' | 'other';

const LEARNT = 3;
const KEY = 'pointbrush.learnt';

export interface Tip {
  readonly text: string;
  readonly lesson: Lesson;
}

/**
 * The words for a device with a part, in the left or the right hand.  Short lines: what is beside a
 * hand must not reach out of the picture.
 */
export function tipsFor(device: Device, part: Part, left: boolean): Tip[] {
  const paints = part === 'brush';
  if (device.pad === 'none') return [onlyTip(device.id === 'hand' ? 'Pinch' : 'Trigger', paints)];
  const tips = paints ? paintingTips(padName(device)) : otherTips(padName(device));
  const moves = device.squeeze >= 0 ? 'Grip' : paints ? '' : 'Trigger';
  if (moves) tips.push(tip(`${moves}: move the room`, 'grab'));
  tips.push(...buttonTips(device, left, paints));
  if (paints && chords(device)) {
    tips.push(tip(`Grip + ${padName(device)} → ↓: size`, 'size'));
  }
  return tips;
}

const BUTTONS = {
  paints: [tip('eraser', 'erase'), tip('undo', 'undo')],
  other: [tip('timeline', 'panel'), tip('redo', 'redo')],
} as const;

function tip(text: string, lesson: Lesson): Tip {
  return { text, lesson };
}

function buttonTips(device: Device, left: boolean, paints: boolean): Tip[] {
  const names = buttonNames(device, left ? 1 : 0);
  return (paints ? BUTTONS.paints : BUTTONS.other).flatMap(({ text, lesson }, i) =>
    names[i] ? [tip(`${names[i]}: ${text}`, lesson)] : [],
  );
}

function onlyTip(act: string, paints: boolean): Tip {
  return paints ? tip(`${act}: paint`, 'paint') : tip(`${act}: move the room`, 'grab');
}

/** The name of a controller's pad in words for a person. */
export function padName({ pad }: Device): string {
  return pad === 'touchpad' ? 'Pad' : 'Stick';
}

function paintingTips(pad: string): Tip[] {
  return [
    tip('Trigger: paint', 'paint'),
    tip('Half pressed: smaller', 'paint'),
    tip(`${pad} ← →: frames`, 'step'),
    tip(`${pad} ↑ ↓: labels`, 'label'),
    tip(`${pad} pressed: play`, 'play'),
  ];
}

function otherTips(pad: string): Tip[] {
  return [
    tip(`${pad} ↑: go there`, 'teleport'),
    tip(`${pad} ← →: turn`, 'turn'),
    tip(`${pad} pressed: doubtful`, 'doubt'),
  ];
}

/** Names of the two buttons, or the chords that stand in for them; empty where there is neither. */
function buttonNames(device: Device, side: 0 | 1): readonly [string, string] {
  const standIn = (arrow: string): string =>
    chords(device) ? `Grip + ${padName(device)} ${arrow}` : '';
  return [
    device.primary >= 0 ? device.primaryName[side] : standIn('↑'),
    device.secondary >= 0 ? device.secondaryName[side] : standIn('←'),
  ];
}

/** Uses of each lesson; kept in the browser. */
export class Lessons {
  /** Told every use of a button. */
  readonly uses = new Listeners<Lesson>();
  private readonly used = new Map<string, number>(load());

  done(lesson: Lesson): void {
    this.uses.run(lesson);
    const times = (this.used.get(lesson) ?? 0) + 1;
    this.used.set(lesson, times);
    if (times > LEARNT) return;
    try {
      localStorage.setItem(KEY, JSON.stringify([...this.used]));
    } catch {
      // Not kept: then it is explained again another day.
    }
  }

  learnt(lesson: Lesson): boolean {
    return (this.used.get(lesson) ?? 0) >= LEARNT;
  }
}

function load(): [string, number][] {
  try {
    const kept: unknown = JSON.parse(localStorage.getItem(KEY) ?? '[]');
    return Array.isArray(kept) ? (kept as [string, number][]) : [];
  } catch {
    return [];
  }
}
