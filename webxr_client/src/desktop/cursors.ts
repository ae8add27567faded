/** Cursors over the picture: a cross, and beside it the sign of the tool or of its shape. */
import { type IconName, ICONS } from '../common/icons';
import { isStroke, type Tool } from '../store/state';
import type { Way } from '../tools/ways';
import type { Handle } from '../tools/volume';

/** Pixels across, and to the middle of the cross. */
const SIZE = 32;
const MIDDLE = 8;
const CROSS = `M${MIDDLE} 1v4M${MIDDLE} 11v4M1 ${MIDDLE}h4M11 ${MIDDLE}h4`;

const SIGNS: Partial<Record<Tool, IconName>> = {
  erase: 'eraser',
  delete: 'noise',
  restore: 'restore',
  pick: 'picker',
  floor: 'plane',
  boxes: 'box',
};

/** White on a dark edge: legible on any recording. */
function drawn(icon: IconName): string {
  const path = (width: number, color: string): string =>
    `<g fill='none' stroke='${color}' stroke-width='${width}' stroke-linecap='round'>` +
    `<path d='${CROSS}'/><path transform='translate(14 14)' d='${ICONS[icon]}'/></g>`;
  const svg =
    `<svg xmlns='http://www.w3.org/2000/svg' width='${SIZE}' height='${SIZE}'>` +
    `${path(3.6, '#05070a')}${path(1.5, '#ffffff')}</svg>`;
  return `url("data:image/svg+xml,${encodeURIComponent(svg)}") ${MIDDLE} ${MIDDLE}, crosshair`;
}

const known = new Map<IconName, string>();

function withSign(icon: IconName): string {
  const cursor = known.get(icon) ?? drawn(icon);
  known.set(icon, cursor);
  return cursor;
}

/** CSS cursor of a tool; `handle`: of a box, under the pointer; `turns`: the camera is turned. */
export function cursorOf(tool: Tool, way: Way, handle: Handle | null, turns: boolean): string {
  if (turns) return 'grabbing';
  if (handle === 'move') return 'move';
  if (handle === 'turn') return 'alias';
  if (handle) return handle.axis === 1 ? 'ns-resize' : 'ew-resize';
  if (tool === 'navigate') return 'grab';
  const sign = SIGNS[tool];
  if (!isStroke(tool) && sign) return withSign(sign);
  // The brush has a ring, so that its cursor shows the tool's sign if any; other shapes show theirs.
  return withSign(way.name === 'ray' && sign ? sign : way.icon);
}
