/** Page of the palette for the trigger's action, and the way that it takes points. */
import { computed } from '@preact/signals';
import { actions } from '../../../store/actions';
import { metres } from '../../../common/format';
import type { IconName } from '../../../common/icons';
import { patch, RADIUS_MAX, RADIUS_MIN, state, type Tool } from '../../../store/state';
import { roomWay, WAYS, type Way } from '../../../tools/ways';
import { change, xrSettings } from '../../../store/xr-settings';
import type { ButtonLook, Ui } from '../../drawing/ui';

const TOOLS: readonly (readonly [Tool, IconName, string])[] = [
  ['paint', 'brush', 'Paint'],
  ['erase', 'eraser', 'Erase'],
  ['delete', 'noise', 'Delete'],
  ['restore', 'restore', 'Restore'],
];

export function drawTools(ui: Ui, x: number, top: number, inner: number): void {
  const { em } = ui;
  const tool = state.tool.peek();
  const half = inner / 2;
  TOOLS.forEach(([id, icon, text], i) => {
    const [column, line] = [i % 2, Math.floor(i / 2)];
    ui.button(x + column * half, top + line * em * 2.3, half - em * 0.2, em * 2.1,
      { icon, text, on: tool === id, strong: true, align: 'left' }, () => actions.setTool(id));
  }); // prettier-ignore
  const way = roomWay();
  const third = inner / 3;
  WAYS.forEach((one, i) => {
    const [column, line] = [i % 3, Math.floor(i / 3)];
    ui.button(x + column * third, top + em * (4.8 + 2.1 * line), third - em * 0.2, em * 2,
      { icon: one.icon, text: one.label, on: way === one, strong: true, align: 'left' }, () => chooseWay(one));
  }); // prettier-ignore
  drawBrush(ui, x, top, inner, way);
}

/** Text of the palette about an object: drawn anew when it changes. */
export const offered = computed(() => {
  const { levels = 0, level = 0, completes = false } = state.object.value ?? {};
  return `${level} of ${levels} ${completes}`;
});

function drawBrush(ui: Ui, x: number, top: number, inner: number, way: Way): void {
  const { em } = ui;
  const completes = state.object.peek()?.completes === true;
  if (completes || way.samples === 'clicks') drawObject(ui, x, top + em * 11.4, inner, completes);
  else drawSize(ui, x, top, inner, way);
  checksOf(way).forEach(([text, on, set], i) => {
    ui.check(x, top + em * (14 + 1.9 * i), inner, em * 1.8, text, on, set);
  });
}

/** The levels of an object, from part to group; or to take what a stroke lies on. */
function drawObject(ui: Ui, x: number, y: number, inner: number, completes: boolean): void {
  const { em } = ui;
  const { levels = 0, level = 0 } = state.object.peek() ?? {};
  const buttons: readonly [ButtonLook, () => void][] = [
    [{ text: 'Smaller', disabled: level <= 0 }, () => actions.stepObject(-1)],
    [{ text: 'Larger', disabled: level >= levels - 1 }, () => actions.stepObject(1)],
    [{ text: 'Complete', disabled: !completes }, () => actions.completeObject()],
  ];
  const w = inner / buttons.length;
  buttons.forEach(([look, act], i) => {
    ui.button(x + i * w, y, w - em * 0.2, em * 2.2, { ...look, strong: true }, act);
  });
}

function drawSize(ui: Ui, x: number, top: number, inner: number, way: Way): void {
  const { em } = ui;
  const { radius } = state.brush.peek();
  const share = Math.log(radius / RADIUS_MIN) / Math.log(RADIUS_MAX / RADIUS_MIN);
  const name = way.size ?? 'Radius';
  ui.slider(
    x + em * 0.4,
    top + em * 11.1,
    inner - em * 0.8,
    em * 2.8,
    name,
    metres(radius),
    share,
    (to) => {
      actions.setRadius(RADIUS_MIN * (RADIUS_MAX / RADIUS_MIN) ** to);
    },
  );
}

type CheckRow = readonly [text: string, on: boolean, set: (on: boolean) => void];

function checksOf(way: Way): readonly CheckRow[] {
  const { onlyUnlabeled, through, takeLabelled, follow, complete } = state.brush.peek();
  const { stopUnsure } = xrSettings.peek();
  const stops: CheckRow = ['Tracking stops when unsure', stopUnsure, (on) => change({ stopUnsure: on })]; // prettier-ignore
  if (way.samples === 'clicks') {
    return [
      ['Take from other labels', takeLabelled, (on) => patch(state.brush, { takeLabelled: on })],
      ['Follow: track painted labels', follow, (on) => patch(state.brush, { follow: on })],
      stops,
    ];
  }
  const offers: CheckRow = ['Offer objects after strokes', complete, (on) => patch(state.brush, { complete: on })]; // prettier-ignore
  const passes: CheckRow = ['Ray goes through', through, (on) => patch(state.brush, { through: on })]; // prettier-ignore
  return [
    ['Only unlabeled points', onlyUnlabeled, (on) => patch(state.brush, { onlyUnlabeled: on })],
    ...(way.samples === 'path' ? [offers] : []),
    way.through ? passes : stops,
  ];
}

export function chooseWay(way: Way): void {
  if (way.name === 'sphere' || way.name === 'ray') change({ tip: way.name });
  actions.setShape(way.shape);
}
