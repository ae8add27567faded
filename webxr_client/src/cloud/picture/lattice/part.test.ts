import { expect, it } from 'vitest';
import { trianglesOf } from './part';

it('makes a surface of no more vertices than there are pixels, each cell twice', () => {
  for (const [columns, rows] of [
    [50, 40],
    [37, 18],
    [1, 5],
  ] as const) {
    const { array } = trianglesOf(columns, rows).getIndex()!;
    const cells = (columns - 1) * (rows - 1);
    expect(array.length).toBe(6 * cells);
    expect(new Set(array).size).toBe(cells > 0 ? columns * rows : 0);
    // Two triangles with the cell's corners, and none that reaches into the next row.
    let narrow = 0;
    for (let i = 0; i < array.length; i += 3) {
      const [a, b, c] = [0, 1, 2].map((k) => array[i + k]! % columns) as [number, number, number];
      if (Math.max(a, b, c) - Math.min(a, b, c) === 1) narrow += 1;
    }
    expect(narrow).toBe(2 * cells);
    expect(trianglesOf(columns, rows)).toBe(trianglesOf(columns, rows));
  }
});
