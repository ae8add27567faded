/** Page of the palette for the view of the recording, and the standpoint in it. */
import { actions } from '../../../store/actions';
import { limits } from '../../../store/limits';
import { hasDepth, sensors } from '../../../store/sensors';
import { state } from '../../../store/state';
import type { Entry, Ui } from '../../drawing/ui';

export interface WorldControls {
  /** 1, 0.1 (doll's house) or 5 (giant's eye). */
  scaleTo(scale: number): void;
  reset(): void;
  /** Stand before the recording again, with the timeline at hand. */
  recentre(): void;
  /** The next press goes where it points. */
  armTeleport(): void;
}

const SCALES = [
  ['1:1', 1],
  ['Doll', 0.1],
  ['Giant', 5],
] as const;

/** Drawing of depth images; a press takes the next mode. */
const SURFACES = [
  ['auto', 'Surface: auto'],
  ['surface', 'Surface: on'],
  ['points', 'Surface: off'],
] as const;

export function drawView(
  ui: Ui,
  x: number,
  top: number,
  inner: number,
  world: WorldControls,
  show: (page: 'recordings' | 'sensors') => void,
): void {
  const { em } = ui;
  drawSliders(ui, x + em * 0.4, top, inner - em * 0.8);
  ui.strip(x, top + em * 7.8, inner, em * 2.2, [
    ...SCALES.map(([text, scale]): Entry => [{ text }, () => world.scaleTo(scale)]),
    [{ text: 'Reset' }, () => world.reset()],
  ]);
  drawChecks(ui, x, top + em * 10.3, inner / 2);
  ui.strip(x, top + em * 14.9, inner, em * 3, [
    [{ icon: 'target', text: 'Recentre' }, () => world.recentre()],
    [{ icon: 'pin', text: 'Go there' }, () => world.armTeleport()],
    [{ icon: 'plane', text: 'Floor' }, () => actions.tools.setTool('floor')],
  ]);
  ui.strip(x, top + em * 18.2, inner, em * 3, [
    [
      { icon: 'folder', text: 'Recordings', disabled: limits.peek() !== null },
      () => show('recordings'),
    ],
    ...(sensors.peek().length > 0
      ? [[{ icon: 'sensors', text: 'Sensors' }, () => show('sensors')] as Entry]
      : []),
    [{ icon: 'exit', text: 'Leave' }, () => void actions.page.exitVR()],
  ]);
}

function drawSliders(ui: Ui, x: number, top: number, wide: number): void {
  const h = ui.em * 2.5;
  const { labelBlend, pointSize, brightness } = state.view.peek();
  ui.slider(x, top, wide, h, 'Labels over colour', `${Math.round(labelBlend * 100)} %`,
    labelBlend, (to) => actions.view.setView({ labelBlend: to })); // prettier-ignore
  ui.slider(x, top + h, wide, h, 'Point size', `${pointSize.toFixed(1)}×`,
    Math.log2(pointSize * 4) / 4, (to) => actions.view.setView({ pointSize: 2 ** (4 * to) / 4 })); // prettier-ignore
  ui.slider(x, top + 2 * h, wide, h, 'Brightness', `${brightness.toFixed(1)}×`,
    Math.log2(brightness * 4) / 4, (to) => actions.view.setView({ brightness: 2 ** (4 * to) / 4 })); // prettier-ignore
}

function drawChecks(ui: Ui, x: number, top: number, half: number): void {
  const { em } = ui;
  let place = 0;
  const check = (name: string, on: boolean, set: (on: boolean) => void): void => {
    const y = top + em * 2.1 * Math.floor(place / 2);
    ui.check(x + (place % 2) * half, y, half, em * 1.9, name, on, set);
    place += 1;
  };
  const { boxes, trails, ghost, surface } = state.view.peek();
  check('Label boxes', boxes, (on) => actions.view.setView({ boxes: on }));
  check('Trails', trails, (on) => actions.view.setView({ trails: on }));
  check('Ghost', ghost, (on) => actions.view.setView({ ghost: on }));
  if (!hasDepth.peek()) return;
  const i = SURFACES.findIndex(([mode]) => mode === surface);
  const next = SURFACES[(i + 1) % SURFACES.length]![0];
  ui.button(x + half, top + em * 2.1, half, em * 1.9, { text: SURFACES[i]![1], strong: true },
    () => actions.view.setView({ surface: next })); // prettier-ignore
}
