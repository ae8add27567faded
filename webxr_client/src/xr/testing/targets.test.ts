import { afterAll, beforeAll, describe, expect, it, vi } from 'vitest';
import { bindActions } from '../../store/actions';
import type { Label } from '../../protocol/messages';
import { halted } from '../../engine/review';
import { projects } from '../../engine/recordings/projects';
import { state } from '../../store/state';
import { chosen, question as handInQuestion, tasks } from '../../work/queue';
import type { PaletteControls, PalettePanel } from '../panels/palette-panel';
import type { Panel } from '../panels/panel';
import { PLACEMENT } from '../panels/placement';
import type { QuestionPanel } from '../panels/question-panel';
import type { TimelinePanel } from '../panels/timeline-panel';

/** Least size of a target: metres, or degrees from where one reads it. */
const LEAST_METRES = 0.022;
const LEAST_DEGREES = 2.5;

/** Words that were drawn since a test emptied this. */
const written: string[] = [];

/** A pen that draws nothing: buttons are laid out by text with a fixed width per letter. */
function pen(): CanvasRenderingContext2D {
  const draws = (): unknown => undefined;
  const measures = (text: string): { width: number } => ({ width: 16 * text.length });
  const writes = (text: string): number => written.push(text);
  const known: Record<string, unknown> = { measureText: measures, fillText: writes };
  return new Proxy(known, {
    get: (fields, name: string) => fields[name] ?? draws,
    set: (fields, name: string, value) => Reflect.set(fields, name, value),
  }) as unknown as CanvasRenderingContext2D;
}

const nothing = (): void => undefined;
const labels = Array.from({ length: 9 }, (_, i) => ({
  id: i + 1,
  name: `pin ${i}`,
  color: '#5ea2ff',
  category: 'pin',
  locked: false,
  visible: true,
})) as unknown as Label[];

let palette: PalettePanel;
let timeline: TimelinePanel;
let question: QuestionPanel;
let now = 0;

/** The smaller side of each button on a panel as drawn now, metres, by name. */
function sides(panel: Panel): Map<string, number> {
  panel.touch();
  panel.update((now += 1000));
  const { width, height } = panel.size;
  const found = panel.places().map(({ name, w, h }) => [name, Math.min(w * width, h * height)]);
  return new Map(found as [string, number][]);
}

function press(panel: Panel, name: string): void {
  sides(panel);
  panel['ui'].areas.find((area) => area.name === name)!.act!(0.5, 0.5);
}

const degrees = (metres: number): number =>
  (2 * Math.atan(metres / 2 / PLACEMENT.distance) * 180) / Math.PI;

beforeAll(async () => {
  vi.stubGlobal('document', { createElement: () => ({ getContext: pen }) });
  vi.stubGlobal('Path2D', Object);
  state.palette.value = labels;
  state.activeLabel.value = 1;
  state.sequences.value = Array.from({ length: 9 }, (_, i) => ({
    id: `run-${i}`,
    name: `Run ${i}`,
    frames: 6,
    damaged: i === 0 ? 'cut short' : null,
  })) as unknown as typeof state.sequences.value;
  const sensors = ['front', 'left'].map((name) => ({ name, type: 'depth', lattice: null, correction: [] })); // prettier-ignore
  state.sequence.value = { id: 'a', frames: 6, fps: 30, sensors } as unknown as typeof state.sequence.value; // prettier-ignore
  state.copies.value = [
    { id: 'a', name: 'A', project: 'p' },
  ] as unknown as typeof state.copies.value;
  projects.value = [{ id: 'p', role: 'reviewer' }] as unknown as typeof projects.value;
  const task = { sequence: 'a', first: 0, last: 5, note: '', reviewer: '' };
  tasks.value = [
    { ...task, number: 1, state: 'taken', assignee: '' },
    { ...task, number: 2, state: 'review', assignee: 'bob' },
  ] as unknown as typeof tasks.value;
  chosen.value = 2;
  const controls = { foldPalette: nothing, toggleTimeline: nothing } as PaletteControls;
  const session = { isSystemKeyboardSupported: false } as unknown as XRSession;
  palette = new (await import('../panels/palette-panel')).PalettePanel(controls, session);
  const bar = { opens: nothing, hide: nothing, callPalette: nothing };
  timeline = new (await import('../panels/timeline-panel')).TimelinePanel(bar);
  question = new (await import('../panels/question-panel')).QuestionPanel(nothing);
});

afterAll(() => {
  for (const panel of [palette, timeline, question]) panel.dispose();
  vi.unstubAllGlobals();
});

describe('what answers on a panel', () => {
  it('is its handle alone while it is folded, as large as anything', () => {
    for (const panel of [palette, timeline]) {
      expect(panel.folded).toBe(true);
      expect([...sides(panel).values()]).toEqual([expect.any(Number)]);
    }
    expect(sides(palette).get('pin 0')).toBeGreaterThanOrEqual(LEAST_METRES);
    expect(degrees(sides(timeline).get('frames')!)).toBeGreaterThanOrEqual(LEAST_DEGREES);
    press(palette, 'pin 0');
    press(timeline, 'frames');
    expect([palette.folded, timeline.folded]).toEqual([false, false]);
  });

  it.each([
    [['Labels']],
    [['Tools']],
    [['View']],
    [['Comfort']],
    [['Fit boxes']],
    [['Teach']],
    [['Work']],
    [['Work', 'Return…']],
    [['Labels', 'New']],
    [['Labels', 'New', 'Type a name']],
    [['Labels', 'Edit']],
    [['Labels', 'Edit', 'Delete']],
    [['View', 'Recordings']],
    [['View', 'Sensors']],
  ])('is as large as a finger needs on the palette: %j', (pages) => {
    for (const page of pages) press(palette, page);
    const found = sides(palette);
    expect(found.size).toBeGreaterThanOrEqual(8);
    for (const [name, side] of found) {
      expect(side, name).toBeGreaterThanOrEqual(LEAST_METRES - 1e-6);
    }
  });

  it('is met by a ray on the timeline, and on the question of a run that stopped', () => {
    halted.value = { at: 0, stop: 5, labels: [1] };
    expect(question.mesh.visible).toBe(true);
    expect([...sides(question).keys()]).toEqual(['Later', 'Continue to 5']);
    for (const panel of [timeline, question]) {
      for (const [name, side] of sides(panel)) {
        expect(degrees(side), name).toBeGreaterThanOrEqual(LEAST_DEGREES);
      }
    }
    expect(sides(timeline).has('Move')).toBe(true);
    // The doubt asks once: below the timeline only after "Later".
    expect(sides(timeline).has('Continue to 5')).toBe(false);
    press(question, 'Later');
    expect(question.mesh.visible).toBe(false);
    expect(sides(timeline).has('Continue to 5')).toBe(true);
    halted.value = null;
  });
});

describe('the palette changes the active label', () => {
  const calls: unknown[] = [];
  const note =
    (name: string) =>
    (...values: unknown[]): Promise<void> => {
      calls.push([name, ...values]);
      return Promise.resolve();
    };
  const names = ['updateLabel', 'renameLabel', 'recolorLabel', 'deleteLabel'] as const;
  let unbind = nothing;
  beforeAll(() => {
    unbind = bindActions({ labels: Object.fromEntries(names.map((name) => [name, note(name)])) });
  });
  afterAll(() => unbind());
  const did = (...pages: string[]): unknown[] => {
    calls.length = 0;
    for (const page of pages) press(palette, page);
    return [...calls];
  };

  it('by a quick name, by letters, by a swatch', () => {
    const renamed = ['updateLabel', 1, { name: 'hand 1', category: 'hand' }];
    expect(did('Labels', 'Edit', 'hand 1')).toEqual([renamed]);
    expect(did('#2fd5e0')).toEqual([['recolorLabel', 1, '#2fd5e0']]);
    expect(did('Type', 'Capitals', 'B', 'Capitals', 'o', 'x', 'x', 'Remove', 'Take')).toEqual([
      ['renameLabel', 1, 'Box'],
    ]);
  });

  it('and deletes it when asked again, the same one', () => {
    expect(did('Labels', 'Edit', 'Delete', 'Keep', 'Delete')).toEqual([]);
    state.activeLabel.value = 2;
    expect(sides(palette).has('Delete it')).toBe(false);
    expect(did('Delete', 'Delete it')).toEqual([['deleteLabel', 2]]);
    expect(sides(palette).has('New')).toBe(true);
  });
});

describe('the palette counts the points of a label', () => {
  it('of this frame and of all before it is deleted, and of all in its row', () => {
    state.activeLabel.value = 1;
    state.counts.value = new Map([[1, 59_726]]);
    const points = Uint32Array.of(20, 3669);
    const row = {
      points,
      painted: points,
      confidence: new Float32Array(2),
      state: new Uint8Array(2),
    };
    state.timeline.value = { rows: new Map([[1, row]]) };
    state.frame.value = 1;
    for (const page of ['Labels', 'Edit', 'Delete']) press(palette, page);
    written.length = 0;
    sides(palette);
    expect(written).toContain('3\u202f669 points in this frame');
    expect(written).toContain('59\u202f726 points in all frames');
    // The question is asked of the frame that is shown.
    state.frame.value = 0;
    written.length = 0;
    palette.update((now += 1000));
    expect(written).toContain('20 points in this frame');
    press(palette, 'Keep');
    press(palette, 'Back');
    written.length = 0;
    sides(palette);
    expect(written).toContain('60\u202fk in all');
  });
});

describe('the palette shows the tasks', () => {
  it('with the steps of the own one and of the one to review', () => {
    press(palette, 'Work');
    const found = sides(palette);
    for (const name of ['Hand in', 'Hand in, next', 'Accept', 'Return…', 'Next to review'])
      expect([...found.keys()]).toContain(name);
  });

  it('and asks before a task without changes is handed in', () => {
    const answers: boolean[] = [];
    const task = tasks.value[0]!;
    handInQuestion.value = { task, answer: (yes) => answers.push(yes) };
    expect(sides(palette).has('Hand in')).toBe(false);
    press(palette, 'Hand in anyway');
    press(palette, 'Keep working');
    expect(answers).toEqual([true, false]);
    handInQuestion.value = null;
  });

  it('offers no step that is impossible, and tells the reason', () => {
    tasks.value = [];
    written.length = 0;
    const found = sides(palette);
    for (const name of ['Next task', 'Next to review', 'Accept'])
      expect(found.has(name)).toBe(false);
    expect(written).toEqual(expect.arrayContaining(['This project has no tasks.', 'No task waits for a review.'])); // prettier-ignore
  });
});

describe('the palette lists recordings', () => {
  it('opens one that is whole', () => {
    const opened: string[] = [];
    const unbind = bindActions({ recordings: { openSequence: (id) => opened.push(id) } });
    for (const name of ['View', 'Recordings', 'next', 'Run 8']) press(palette, name);
    expect(sides(palette).has('Run 0')).toBe(false);
    expect(opened).toEqual(['run-8']);
    unbind();
  });
});
