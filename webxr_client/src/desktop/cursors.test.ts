import { expect, test } from 'vitest';
import { DESK_WAYS } from '../tools/ways';
import { cursorOf } from './cursors';

const [object] = DESK_WAYS;

test('each tool and each shape has a cursor of its own, and the camera and handles have theirs', () => {
  const shapes = DESK_WAYS.map((way) => cursorOf('paint', way, null, false));
  const brush = DESK_WAYS.find(({ name }) => name === 'ray')!;
  const tools = (['erase', 'delete', 'restore', 'pick', 'navigate'] as const).map((tool) =>
    cursorOf(tool, brush, null, false),
  );
  const all = [...shapes, ...tools, cursorOf('paint', object!, null, true)];
  expect(new Set(all).size).toBe(all.length);
  expect(cursorOf('paint', object!, { axis: 1, side: 1 }, false)).toBe('ns-resize');
  for (const cursor of shapes)
    expect(cursor).toMatch(/^url\("data:image\/svg\+xml,%3Csvg[^"]*"\) 8 8, crosshair$/);
});
