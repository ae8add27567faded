import { readFileSync, writeFileSync } from 'node:fs';
import { afterEach, describe, expect, it, vi } from 'vitest';
import { ACTIONS, waysOf, type Action } from './gestures';
import { registered } from './registry';
import { TestSource, Worn } from './sources';

const DOCS = '../docs/headset-devices.md';
const [BEGIN, END] = ['<!-- devices: made by device-table.test.ts -->', '<!-- /devices -->'];

const both = (id: string, joints = false): TestSource[] => [
  registered(id, 'left', joints),
  registered(id, 'right', joints),
];
const one = (id: string, joints = false): TestSource[] => [registered(id, 'right', joints)];
/** A source of a kind that only selects. */
const only = (mode: string, side: XRHandedness = 'none'): TestSource[] => [
  new TestSource({ mode, side, profile: 'generic-button' }),
];

const ROWS: readonly (readonly [string, () => TestSource[]])[] = [
  ['Quest 2', () => both('oculus-touch-v3')],
  ['Quest 3', () => both('meta-quest-touch-plus')],
  ['Quest 3S', () => both('meta-quest-touch-plus-v2')],
  ['Quest Pro', () => both('meta-quest-touch-pro')],
  ['Quest 3, one controller', () => one('meta-quest-touch-plus')],
  ['Vive, two wands', () => both('htc-vive')],
  ['Vive, two wands with joints', () => both('htc-vive', true)],
  ['Vive, one wand', () => one('htc-vive')],
  ['Vive, one wand with joints', () => one('htc-vive', true)],
  ['Index', () => both('valve-index')],
  ['Index with joints', () => both('valve-index', true)],
  ['Index, one controller', () => one('valve-index')],
  ['Windows MR', () => both('microsoft-mixed-reality')],
  ['HP Reverb G2', () => both('hp-mixed-reality')],
  ['Pico 4', () => both('pico-4')],
  ['Vive Focus 3', () => both('htc-vive-focus-3')],
  ['Galaxy XR', () => both('samsung-galaxyxr')],
  ['Magic Leap 2', () => one('magicleap-two', true)],
  ['Logitech MX Ink', () => one('logitech-mx-ink')],
  ['Oculus Go', () => one('oculus-go')],
  ['Vision Pro', () => only('transient-pointer', 'right')],
  ['bare hands', () => both('generic-hand-select', true)],
  ['gaze', () => only('gaze')],
  ['phone', () => only('screen')],
];

/** Actions that stand on panels for every device: rare, and not to be done by accident. */
const PANELS: readonly Action[] = ['track', 'question', 'another recording', 'leave'];
/** Devices without buttons of their own for more than painting. */
const BUTTONLESS = ['Logitech MX Ink', 'Vision Pro', 'bare hands', 'gaze', 'phone'];
const GRIPLESS = ['Oculus Go'];

/** Words for the press of a kind without a trigger. */
const PRESSES = new Map([
  ['hand', 'pinch'],
  ['look and pinch', 'pinch'],
  ['touch', 'finger'],
  ['gaze', 'select'],
]);

/** Whether the press of what paints is heard: it paints, and presses panels. */
function presses(worn: Worn, source: TestSource): boolean {
  const { brush } = worn.pointers;
  worn.go();
  const trigger = source.gamepad?.buttons[brush!.device.trigger];
  if (trigger) trigger.value = 1;
  else worn.select(source, true);
  worn.go();
  const heard = brush!.trigger > 0 && brush!.edge.click === 1;
  if (trigger) trigger.value = 0;
  else worn.select(source, false);
  worn.go();
  return heard;
}

function rowOf(sources: TestSource[]): Record<Action, string> {
  const worn = new Worn(...sources);
  const { brush } = worn.pointers;
  const pressed = presses(worn, brush!.source as unknown as TestSource);
  const found = waysOf(worn);
  const named = PRESSES.get(brush!.kind.name) ?? 'trigger';
  const cell = (action: Action): string => {
    if (action === 'enter') return 'page';
    if (action === 'paint') return pressed ? named : 'no';
    if (action === 'panels' && brush!.kind.name === 'hand') return 'palm';
    return found.get(action) ?? (pressed ? 'panel' : 'no');
  };
  return Object.fromEntries(ACTIONS.map((action) => [action, cell(action)])) as Record<Action, string>;
} // prettier-ignore

/** Actions that each device has its own way for: those of the documentation's table. */
const OWN = ACTIONS.filter((action) => action !== 'enter' && !PANELS.includes(action));

/** A row for all devices that do the same. */
const TABLE = (): string => {
  const line = (cells: readonly string[]): string => `| ${cells.join(' | ')} |`;
  const named = new Map<string, string[]>();
  for (const [name, sources] of ROWS) {
    const row = rowOf(sources());
    const ways = OWN.map((action) => row[action]).join(' | ');
    named.set(ways, [...(named.get(ways) ?? []), name]);
  }
  const rows = [...named].map(([ways, names]) => [names.join('; '), ways]);
  const head = ['device', ...OWN];
  return [head, head.map(() => '---'), ...rows].map(line).join('\n');
};

afterEach(() => vi.unstubAllGlobals());

describe('what each device can do', () => {
  it.each(ROWS)('%s: everything, by its own buttons where it has them', (name, sources) => {
    const row = rowOf(sources());
    expect(Object.values(row)).not.toContain('no');
    if (BUTTONLESS.includes(name)) return;
    const gripless: readonly Action[] = GRIPLESS.includes(name) ? ['erase', 'undo'] : [];
    const alone = sources().length === 1;
    for (const action of ACTIONS.filter((each) => !PANELS.includes(each))) {
      if (gripless.includes(action) || (alone && action === 'panels')) continue;
      expect(row[action], action).not.toBe('panel');
    }
  });

  it('stands in the documentation; WRITE_TABLE=1 writes it there', () => {
    const text = readFileSync(DOCS, 'utf8');
    const [before = '', rest = ''] = text.split(`${BEGIN}\n`);
    const after = rest.slice(rest.indexOf(END));
    const wanted = `${before}${BEGIN}\n${TABLE()}\n${after}`;
    if (process.env['WRITE_TABLE']) writeFileSync(DOCS, wanted);
    else expect(text).toBe(wanted);
  });
});
