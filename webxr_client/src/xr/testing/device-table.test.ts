import { readFileSync, writeFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { Bench } from './bench';
import { ACTIONS, waysOf, type Action } from './gestures';
import type { TestSource } from './sources';
import { WORN_DEVICES } from './worn-devices';

const DOCS = '../docs/headset-devices.md';
const [BEGIN, END] = ['<!-- devices: made by device-table.test.ts -->', '<!-- /devices -->'];

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

function rowOf(sources: TestSource[]): Record<Action, string> {
  const bench = new Bench(...sources);
  const { brush } = bench.inputs.pointers;
  bench.stroke();
  const pressed = bench.edits.length > 0;
  const found = waysOf(bench);
  bench.dispose();
  const named = PRESSES.get(brush!.kind.name) ?? 'trigger';
  const cell = (action: Action): string => {
    if (action === 'enter') return 'page';
    if (action === 'paint') return pressed ? named : 'no';
    if (action === 'panels' && brush!.kind.name === 'hand') return 'palm';
    return found.get(action) ?? (pressed ? 'panel' : 'no');
  };
  return Object.fromEntries(ACTIONS.map((action) => [action, cell(action)])) as Record<Action, string>;
} // prettier-ignore

/** Actions with an own gesture on each device, as in the documentation's table. */
const OWN = ACTIONS.filter((action) => action !== 'enter' && !PANELS.includes(action));

/** A row for all devices that do the same. */
const TABLE = (): string => {
  const line = (cells: readonly string[]): string => `| ${cells.join(' | ')} |`;
  const named = new Map<string, string[]>();
  for (const [name, sources] of WORN_DEVICES) {
    const row = rowOf(sources());
    const ways = OWN.map((action) => row[action]).join(' | ');
    named.set(ways, [...(named.get(ways) ?? []), name]);
  }
  const rows = [...named].map(([ways, names]) => [names.join('; '), ways]);
  const head = ['device', ...OWN];
  return [head, head.map(() => '---'), ...rows].map(line).join('\n');
};

describe('what each device can do', () => {
  it.each(WORN_DEVICES)('%s: everything, by its own buttons where it has them', (name, sources) => {
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
