import { describe, expect, it } from 'vitest';
import { clearBefore, solidBefore, sortInPlace, type Drawn } from './draw-order';

const entry = (id: number, renderOrder: number, z: number, material: number): Drawn => ({
  id,
  groupOrder: 0,
  renderOrder,
  z,
  material: { id: material },
  materialVariant: 0,
});
const ids = (list: Drawn[]): number[] => list.map(({ id }) => id);

describe('what is drawn', () => {
  const list = [
    entry(1, 100, 0.2, 1),
    entry(2, 0, 0.9, 2),
    entry(3, 0, 0.1, 2),
    entry(4, 0, 0.5, 1),
    entry(5, -5, 0.5, 3),
    entry(6, 0, 0.1, 2),
  ];

  it('is ordered by hand, then by material, then from near to far where it is solid', () => {
    expect(ids(sortInPlace([...list], solidBefore))).toEqual([5, 4, 3, 6, 2, 1]);
  });

  it('is ordered by hand, then from far to near where one sees through it', () => {
    expect(ids(sortInPlace([...list], clearBefore))).toEqual([5, 2, 4, 3, 6, 1]);
  });

  it('stays the same list', () => {
    const mine = [...list];
    expect(sortInPlace(mine, clearBefore)).toBe(mine);
    expect(sortInPlace<Drawn>([], clearBefore)).toEqual([]);
  });
});
