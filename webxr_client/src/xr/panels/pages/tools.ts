/** Page of the palette for the trigger's action, and the way that it takes points. */
import { computed } from '@preact/signals';
import { actions } from '../../../store/actions';
import { metres } from '../../../common/format';
import type { IconName } from '../../../common/icons';
import { offers } from '../../../store/limits';
import { patch, RADIUS_MAX, RADIUS_MIN, state, type Tool } from '../../../store/state';
import { roomWay, WAYS, type Way } from '../../../tools/ways';
import { change, xrSettings } from '../../../store/xr-settings';
import { INK, type Entry, type Ui } from '../../drawing/ui';

const TOOLS: readonly (readonly [Tool, IconName, string])[] = [
  ['paint', 'brush', 'Paint'],
  ['erase', 'eraser', 'Erase'],
  ['delete', 'noise', 'Delete'],
  ['restore', 'restore', 'Restore'],
];

/** Tiles beside one another; ems of a strip's name, of a tile's height, and below a strip. */
const [COLUMNS, NAME, TILE, GAP] = [4, 1.4, 3, 0.3];
/** Ems from the top to each strip's name, and to the controls of the chosen shape. */
const SHAPES = NAME + TILE + GAP;
const BRUSH = SHAPES + NAME + 2 * TILE + GAP;

export function drawTools(ui: Ui, x: number, top: number, inner: number): void {
  const { em } = ui;
  const tool = state.tool.peek();
  const way = roomWay();
  const strip = (name: string, at: number, entries: readonly Entry[]): void => {
    ui.text(name, x + em * 0.4, top + em * (at + 0.6), { color: INK.quiet });
    ui.strip(x, top + em * (at + NAME), inner, em * TILE, entries, COLUMNS);
  };
  strip('Selection', 0, TOOLS.filter(([id]) => offers(id)).map(([id, icon, text]) =>
    [{ icon, text, on: tool === id }, () => actions.tools.setTool(id)])); // prettier-ignore
  strip('Shape', SHAPES, WAYS.filter(({ shape }) => offers(shape)).map((one) =>
    [{ icon: one.icon, text: one.label, on: way === one }, () => chooseWay(one)])); // prettier-ignore
  drawBrush(ui, x, top + em * BRUSH, inner, way);
}

/** Text of the palette about an object: drawn anew when it changes. */
export const offered = computed(() => {
  const { levels = 0, level = 0, completes = false } = state.object.value ?? {};
  return `${level} of ${levels} ${completes}`;
});

function drawBrush(ui: Ui, x: number, top: number, inner: number, way: Way): void {
  const { em } = ui;
  const completes = state.object.peek()?.completes === true;
  if (completes || way.samples === 'clicks') drawObject(ui, x, top, inner, completes);
  else drawSize(ui, x + em * 0.4, top, inner - em * 0.8, way);
  checksOf(way).forEach(([text, on, set], i) => {
    ui.check(x, top + em * (3 + 1.95 * i), inner, em * 1.85, text, on, set);
  });
}

/** The levels of an object, from part to group; or the choice to take the object of a stroke. */
function drawObject(ui: Ui, x: number, y: number, inner: number, completes: boolean): void {
  const { levels = 0, level = 0 } = state.object.peek() ?? {};
  ui.strip(x, y, inner, ui.em * 2.6, [
    [{ text: 'Smaller', disabled: level <= 0 }, () => actions.tools.stepObject(-1)],
    [{ text: 'Larger', disabled: level >= levels - 1 }, () => actions.tools.stepObject(1)],
    [{ text: 'Complete', disabled: !completes }, () => actions.tools.completeObject()],
  ]);
}

function drawSize(ui: Ui, x: number, y: number, wide: number, way: Way): void {
  const { radius } = state.brush.peek();
  const share = Math.log(radius / RADIUS_MIN) / Math.log(RADIUS_MAX / RADIUS_MIN);
  ui.slider(x, y, wide, ui.em * 2.7, way.size ?? 'Radius', metres(radius), share, (to) =>
    actions.tools.setRadius(RADIUS_MIN * (RADIUS_MAX / RADIUS_MIN) ** to),
  );
}

type CheckRow = readonly [text: string, on: boolean, set: (on: boolean) => void];

function checksOf(way: Way): readonly CheckRow[] {
  const { onlyUnlabeled, through, takeLabelled, follow, complete } = state.brush.peek();
  const { stopUnsure } = xrSettings.peek();
  const stops: CheckRow = ['Tracking stops when unsure', stopUnsure, (on) => change({ stopUnsure: on })]; // prettier-ignore
  if (way.samples === 'clicks') {
    return [
      ['Overwrite other labels', takeLabelled, (on) => patch(state.brush, { takeLabelled: on })],
      ['Follow: track painted labels', follow, (on) => patch(state.brush, { follow: on })],
      stops,
    ];
  }
  const offers: CheckRow = ['Offer objects after strokes', complete, (on) => patch(state.brush, { complete: on })]; // prettier-ignore
  const passes: CheckRow = ['Ray goes through', through, (on) => patch(state.brush, { through: on })]; // prettier-ignore
  return [
    ['Only unlabelled points', onlyUnlabeled, (on) => patch(state.brush, { onlyUnlabeled: on })],
    ...(way.samples === 'path' ? [offers] : []),
    way.through ? passes : stops,
  ];
}

export function chooseWay(way: Way): void {
  if (way.name === 'sphere' || way.name === 'ray') change({ tip: way.name });
  actions.tools.setShape(way.shape);
}
