/** Lessons: each button's action in words, and its uses, since what is learnt needs no words. */
import { chords, type Device } from './devices';

export type Lesson = 'paint' | 'step' | 'play' | 'size' | 'grab' | 'erase' | 'undo' | 'teleport' | 'turn' | 'panel' | 'redo' | 'doubt' | 'label'; // prettier-ignore

const LEARNT = 3;
const KEY = 'pointbrush.learnt';

export interface Tip {
  readonly text: string;
  readonly lesson: Lesson;
}

/** The words for a device in the hand that paints, or in the other one. */
export function tipsFor(device: Device, paints: boolean, left: boolean): Tip[] {
  const side = left ? 1 : 0;
  const tips: Tip[] = [];
  // Short lines: what is beside a hand must not reach out of the picture.
  const tip = (text: string, lesson: Lesson): number => tips.push({ text, lesson });
  if (device.pad === 'none') {
    const act = device.id === 'hand' ? 'Pinch' : 'Trigger';
    if (paints) tip(`${act}: paint`, 'paint');
    else tip(`${act}: move the room`, 'grab');
    return tips;
  }
  const pad = device.pad === 'stick' ? 'Stick' : 'Pad';
  if (paints) {
    tip('Trigger: paint', 'paint');
    tip('Half pressed: smaller', 'paint');
    tip(`${pad} ← →: frames`, 'step');
    tip(`${pad} ↑ ↓: size`, 'size');
    tip(`${pad} pressed: play`, 'play');
  } else {
    tip(`${pad} ↑: go there`, 'teleport');
    tip(`${pad} ← →: turn`, 'turn');
    tip(`${pad} ↓: next label`, 'label');
    tip(`${pad} pressed: doubtful`, 'doubt');
  }
  if (device.squeeze >= 0) tip('Grip: move the room', 'grab');
  else if (!paints) tip('Trigger: move the room', 'grab');
  const chord = chords(device);
  const first = chord ? `Grip + ${pad} ↑` : device.primaryName[side];
  const second = chord ? `Grip + ${pad} ←` : device.secondaryName[side];
  if (first) tip(`${first}: ${paints ? 'eraser' : 'timeline'}`, paints ? 'erase' : 'panel');
  if (second) tip(`${second}: ${paints ? 'undo' : 'redo'}`, paints ? 'undo' : 'redo');
  return tips;
}

/** Uses of each lesson; kept in the browser. */
export class Lessons {
  private readonly used = new Map<string, number>(load());

  done(lesson: Lesson): void {
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
