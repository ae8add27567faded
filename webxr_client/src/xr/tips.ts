/** What each button does, written on the controller, until it has been used a few times. */
import { Group } from 'three';
import type { Device } from './devices';
import type { Hand } from './hand';
import { Sign } from './sign';
import { SIZES } from './sizes';

export type Lesson = 'paint' | 'step' | 'play' | 'size' | 'grab' | 'erase' | 'undo' | 'teleport' | 'turn' | 'panel' | 'redo' | 'doubt'; // prettier-ignore

const LEARNT = 3;
const KEY = 'pointbrush.learnt';

interface Tip {
  readonly text: string;
  readonly lessons: readonly Lesson[];
}

/** The words for a device in the hand that paints, or in the other one. */
export function tipsFor(device: Device, paints: boolean, left: boolean): Tip[] {
  const side = left ? 1 : 0;
  const tips: Tip[] = [];
  if (device.pad === 'none') {
    const act = device.id === 'hand' ? 'Pinch' : 'Trigger';
    return paints
      ? [{ text: `${act}: paint`, lessons: ['paint'] }]
      : [{ text: `${act}: move the room`, lessons: ['grab'] }];
  }
  const pad = device.pad === 'stick' ? 'Stick' : 'Pad';
  if (paints) {
    tips.push({ text: 'Trigger: paint (half: smaller)', lessons: ['paint'] });
    tips.push({
      text: `${pad} ← →: frames   ↑ ↓: size`,
      lessons: ['step', 'size'],
    });
    tips.push({ text: `${pad} pressed: play`, lessons: ['play'] });
  } else {
    tips.push({
      text: `${pad} ↑: go there   ← →: turn`,
      lessons: ['teleport', 'turn'],
    });
    tips.push({ text: `${pad} pressed: next doubtful`, lessons: ['doubt'] });
  }
  if (device.squeeze >= 0) {
    tips.push({ text: 'Grip: move the room', lessons: ['grab'] });
  } else if (!paints) {
    tips.push({ text: 'Trigger: move the room', lessons: ['grab'] });
  }
  const [first, second] = [device.primaryName[side], device.secondaryName[side]];
  if (first)
    tips.push({
      text: `${first}: ${paints ? 'eraser' : 'timeline'}`,
      lessons: [paints ? 'erase' : 'panel'],
    });
  if (second)
    tips.push({
      text: `${second}: ${paints ? 'undo' : 'redo'}`,
      lessons: [paints ? 'undo' : 'redo'],
    });
  return tips;
}

/** How often each lesson was used; kept in the browser. */
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

  learnt(lessons: readonly Lesson[]): boolean {
    for (let i = 0; i < lessons.length; i++) {
      if ((this.used.get(lessons[i]!) ?? 0) < LEARNT) return false;
    }
    return true;
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

const FADE_PER_SECOND = 2;
/** Metres on the grip: the first line, and from one line to the next. */
const TOP = 0.075;
const LINE = 0.0265;

export class Tips {
  readonly group = new Group();
  private entries: { tip: Tip; sign: Sign; opacity: number }[] = [];

  constructor(private readonly lessons: Lessons) {}

  set(hand: Hand, paints: boolean): void {
    this.clear();
    if (!hand.device) return;
    const mirror = hand.side === 'left' ? -1 : 1;
    for (const [line, tip] of tipsFor(hand.device, paints, hand.side === 'left').entries()) {
      const sign = new Sign({ em: SIZES.tips.em });
      sign.write(tip.text);
      const half = sign.mesh.scale.x / 2;
      // One below the other, beside the controller, to the outside.
      sign.mesh.position.set(
        mirror * (0.045 + half),
        TOP - line * LINE * 0.73,
        -0.03 + line * LINE * 0.68,
      );
      sign.mesh.rotation.x = -0.7;
      this.group.add(sign.mesh);
      this.entries.push({ tip, sign, opacity: 1 });
    }
    hand.grip.add(this.group);
  }

  update(seconds: number, shown: boolean): void {
    for (let i = 0; i < this.entries.length; i++) {
      const entry = this.entries[i]!;
      const goal = shown && !this.lessons.learnt(entry.tip.lessons) ? 1 : 0;
      const step = Math.min(1, FADE_PER_SECOND * seconds);
      entry.opacity +=
        Math.sign(goal - entry.opacity) * Math.min(step, Math.abs(goal - entry.opacity));
      entry.sign.mesh.material.opacity = entry.opacity;
      entry.sign.mesh.visible = entry.opacity > 0.01;
    }
  }

  /** What can be read now, for tests. */
  get shown(): string[] {
    return this.entries.flatMap(({ tip, sign }) => (sign.mesh.visible ? tip.text : []));
  }

  clear(): void {
    for (const { sign } of this.entries) sign.dispose();
    this.entries = [];
    this.group.removeFromParent();
  }
}
