/** How the recording is shown, and how one stands in it. */
import { actions } from '../../actions';
import { state } from '../../state';
import { change, xrSettings } from '../settings';
import type { ButtonLook, Ui } from '../ui';

export interface WorldControls {
  /** 1, 0.1 (doll's house) or 5 (giant's eye). */
  scaleTo(scale: number): void;
  reset(): void;
  /** Stand before the recording again, with the timeline at hand. */
  recentre(): void;
  /** The next press goes where it points. */
  go(): void;
}

const SCALES = [
  ['1:1', 1],
  ['Doll', 0.1],
  ['Giant', 5],
] as const;

export function drawView(
  ui: Ui,
  x: number,
  top: number,
  inner: number,
  world: WorldControls,
): void {
  const { em } = ui;
  drawSliders(ui, x + em * 0.4, top, inner - em * 0.8);
  const w = inner / 4;
  const y = top + em * 7.7;
  SCALES.forEach(([text, scale], i) => {
    ui.button(x + i * w, y, w - em * 0.2, em * 2, { text, strong: true }, () =>
      world.scaleTo(scale),
    );
  });
  ui.button(x + 3 * w, y, w - em * 0.2, em * 2, { text: 'Reset', strong: true }, () =>
    world.reset(),
  );
  drawChecks(ui, x, top + em * 9.9, inner / 2);
  drawEnd(ui, x, top + em * 18, inner, world);
}

/** Degrees that one turns by at a flick of the stick; 0: evenly, as long as it leans. */
const TURNS = [30, 45, 90, 0];

/** The widths of the last row's buttons, in shares of it. */
const END = [0.23, 0.21, 0.2, 0.14, 0.22] as const;

function drawEnd(ui: Ui, x: number, y: number, inner: number, world: WorldControls): void {
  const { snap } = xrSettings.peek();
  const turn = snap > 0 ? `Turn ${snap}°` : 'Turn evenly';
  const buttons: readonly [ButtonLook, () => void][] = [
    [{ text: turn }, () => change({ snap: TURNS[(TURNS.indexOf(snap) + 1) % TURNS.length]! })],
    [{ text: 'Recentre' }, () => world.recentre()],
    [{ text: 'Go there' }, () => world.go()],
    [{ text: 'Floor' }, () => actions.setTool('floor')],
    [{ icon: 'exit', text: 'Leave' }, () => void actions.exitVR()],
  ];
  let left = x;
  buttons.forEach(([look, act], i) => {
    const w = END[i]! * inner;
    ui.button(left, y, w - ui.em * 0.2, ui.em * 2.1, { ...look, strong: true }, act);
    left += w;
  });
}

function drawSliders(ui: Ui, x: number, top: number, wide: number): void {
  const h = ui.em * 2.5;
  const { labelBlend, pointSize, brightness } = state.view.peek();
  ui.slider(x, top, wide, h, 'Labels over colour', `${Math.round(labelBlend * 100)} %`,
    labelBlend, (to) => actions.setView({ labelBlend: to })); // prettier-ignore
  ui.slider(x, top + h, wide, h, 'Point size', `${pointSize.toFixed(1)}×`,
    Math.log2(pointSize * 4) / 4, (to) => actions.setView({ pointSize: 2 ** (4 * to) / 4 })); // prettier-ignore
  ui.slider(x, top + 2 * h, wide, h, 'Brightness', `${brightness.toFixed(1)}×`,
    Math.log2(brightness * 4) / 4, (to) => actions.setView({ brightness: 2 ** (4 * to) / 4 })); // prettier-ignore
}

function drawChecks(ui: Ui, x: number, top: number, half: number): void {
  const { em } = ui;
  let place = 0;
  const check = (name: string, on: boolean, set: (on: boolean) => void): void => {
    const y = top + em * 2 * Math.floor(place / 2);
    ui.check(x + (place % 2) * half, y, half, em * 1.9, name, on, set);
    place += 1;
  };
  const { boxes, trails, ghost } = state.view.peek();
  check('Boxes', boxes, (on) => actions.setView({ boxes: on }));
  check('Trails', trails, (on) => actions.setView({ trails: on }));
  check('Ghost', ghost, (on) => actions.setView({ ghost: on }));
  const { hand, move, vignette, seated, tips } = xrSettings.peek();
  check('Button tips', tips, (on) => change({ tips: on }));
  check('Left-handed', hand === 'left', (on) => change({ hand: on ? 'left' : 'right' }));
  check('Glide', move === 'smooth', (on) => change({ move: on ? 'smooth' : 'teleport' }));
  check('Seated', seated, (on) => change({ seated: on }));
  check('Vignette', vignette, (on) => change({ vignette: on }));
}
