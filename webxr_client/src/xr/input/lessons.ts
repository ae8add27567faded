/** Lessons: each button's action in words, and its uses, since what is learnt needs no words. */
import { Listeners } from '../../store/listeners';
import { chords, type Device } from './devices';

export type Lesson = 'paint' | 'step' | 'play' | 'size' | 'grab' | 'erase' | 'undo' | 'teleport' | 'turn' | 'panel' | 'redo' | 'doubt' | 'label'; // prettier-ignore

/** Task of a controller: it paints and no other hand is there, it paints, or it helps. */
export type Part = 'alone' | 'brush' | 'other';

const LEARNT = 3;
const KEY = 'pointbrush.learnt';

export interface Tip {
  readonly text: string;
  readonly lesson: Lesson;
}

/** The words for a device with a part, in the left or the right hand. */
export function tipsFor(device: Device, part: Part, left: boolean): Tip[] {
  const paints = part !== 'other';
  const tips: Tip[] = [];
  // Short lines: what is beside a hand must not reach out of the picture.
  const tip = (text: string, lesson: Lesson): number => tips.push({ text, lesson });
  if (device.pad === 'none') {
    const act = device.id === 'hand' ? 'Pinch' : 'Trigger';
    if (paints) tip(`${act}: paint`, 'paint');
    else tip(`${act}: move the room`, 'grab');
    return tips;
  }
  const touches = device.pad === 'touchpad';
  const pad = touches ? 'Pad' : 'Stick';
  if (paints) {
    tip('Trigger: paint', 'paint');
    tip('Half pressed: smaller', 'paint');
    tip(`${pad} ← →: frames`, 'step');
    if (part === 'alone' && touches) tip('Pad ↑ ↓: labels', 'label');
    else tip(`${pad} ↑ ↓: size`, 'size');
    tip(`${pad} pressed: play`, 'play');
  } else {
    tip(`${pad} ↑: go there`, 'teleport');
    tip(`${pad} ← →: turn`, 'turn');
    if (touches) tip('Pad ↓: next label', 'label');
    tip(`${pad} pressed: doubtful`, 'doubt');
  }
  if (device.second) tip('Pad ↑ ↓: labels', 'label');
  if (device.squeeze >= 0) tip('Grip: move the room', 'grab');
  else if (!paints) tip('Trigger: move the room', 'grab');
  const [first, second] = buttonNames(device, left ? 1 : 0);
  if (first) tip(`${first}: ${paints ? 'eraser' : 'timeline'}`, paints ? 'erase' : 'panel');
  if (second) tip(`${second}: ${paints ? 'undo' : 'redo'}`, paints ? 'undo' : 'redo');
  if (chords(device) && !touches) tip('Grip + Stick ↓: next label', 'label');
  return tips;
}

/** Names of the two buttons, or the chords that stand in for them; empty where there is neither. */
function buttonNames(device: Device, side: 0 | 1): readonly [string, string] {
  const pad = device.pad === 'stick' ? 'Stick' : 'Pad';
  const standIn = (arrow: string): string => (chords(device) ? `Grip + ${pad} ${arrow}` : '');
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
