import { describe, expect, it } from 'vitest';
import { CELL_STATES, type TimelineRow } from '../store/state';
import { runOver, stretchAt } from './review';

/** A label frame by frame: p painted, t tracked, d doubtful, l lost, . nothing. */
function row(cells: string): TimelineRow {
  const kinds = cells.split('');
  const state = { p: 'painted', t: 'tracked', d: 'tracked', l: 'lost', '.': 'none' } as const;
  return {
    points: Uint32Array.from(kinds, (kind) => ('ptd'.includes(kind) ? 9 : 0)),
    painted: Uint32Array.from(kinds, (kind) => (kind === 'p' ? 9 : 0)),
    confidence: Float32Array.from(kinds, (kind) => (kind === 'd' ? 0.2 : 1)),
    state: Uint8Array.from(kinds, (kind) => CELL_STATES.indexOf(state[kind as keyof typeof state])),
  };
}

describe('a doubtful stretch', () => {
  const rows = new Map([
    [1, row('ptddltp..d')],
    [2, row('pppppppppp')],
  ]);
  const at = (frame: number) => stretchAt(rows, frame, 10);

  it('is all doubtful frames round one, of the labels that are doubtful there', () => {
    expect(at(3)).toEqual({ labels: [1], start: 2, stop: 4 });
    expect(at(9)).toEqual({ labels: [1], start: 9, stop: 9 });
    expect(at(7)).toBe(null);
  });

  it('is also found from the sure frame beside it, where one mends', () => {
    expect(at(1)).toEqual(at(3));
    expect(at(5)).toEqual(at(3));
    expect(at(0)).toBe(null);
  });

  it('is tracked again from the sure frame before it, else from the one behind', () => {
    expect(runOver(at(3)!, rows)).toEqual({ labels: [1], start: 1, stop: 4 });
    const behind = new Map([[1, row('ddp')]]);
    expect(runOver(stretchAt(behind, 0, 3)!, behind)).toEqual({ labels: [1], start: 2, stop: 0 });
    const alone = new Map([[1, row('ddd')]]);
    expect(runOver(stretchAt(alone, 0, 3)!, alone)).toBe(null);
  });
});
