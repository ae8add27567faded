import { describe, expect, it } from 'vitest';
import { Touches } from './touches';

const at = (pointerId: number, offsetX: number, offsetY: number, pointerType = 'touch') =>
  ({ pointerId, offsetX, offsetY, pointerType }) as PointerEvent;

describe('fingers on the canvas', () => {
  it('are a pinch from the second one on, until all are up', () => {
    const touches = new Touches();
    expect(touches.down(at(1, 0, 0))).toBe(false);
    expect(touches.move(at(1, 5, 0))).toBeNull();
    expect(touches.down(at(2, 105, 0))).toBe(true);
    expect(touches.move(at(2, 205, 0))).toMatchObject({ dx: 50, dy: 0, grown: 2 });
    expect(touches.up(at(1, 5, 0))).toBe(true);
    expect(touches.move(at(2, 300, 0))).toBeNull();
    expect(touches.up(at(2, 300, 0))).toBe(false);
  });

  it('are not what a mouse is', () => {
    const touches = new Touches();
    touches.down(at(1, 0, 0));
    expect(touches.down(at(2, 9, 9, 'mouse'))).toBe(false);
  });
});
