/** The panel on the other hand: labels, tools, view. */
import { actions } from '../actions';
import type { Label } from '../protocol/messages';
import { activeLabel, patch, RADIUS_MAX, RADIUS_MIN, state, type Tool } from '../state';
import { suggestColor, suggestName } from '../panels/colors';
import { metres, shortCount } from '../panels/format';
import type { IconName } from '../panels/icons';
import { currentWay, type Way } from './brush';
import { Panel } from './panel';
import { watch } from './watch';
import { change, xrSettings } from './settings';
import { INK, type Ui } from './ui';

type Tab = 'labels' | 'tools' | 'view' | 'new';

const ROWS = 6;
const QUICK = ['pin', 'hand', 'person', 'ball', 'head', 'object', 'vehicle', 'table'];

const TOOLS: readonly (readonly [Tool, IconName, string])[] = [
  ['paint', 'brush', 'Paint'],
  ['erase', 'eraser', 'Erase'],
  ['delete', 'noise', 'Delete'],
  ['restore', 'restore', 'Restore'],
];

const WAYS: readonly (readonly [Way, IconName, string])[] = [
  ['ball', 'brush', 'Ball'],
  ['ray', 'target', 'Ray'],
  ['fill', 'fill', 'Fill'],
  ['lasso', 'lasso', 'Lasso'],
  ['box', 'view', 'Box'],
];

export interface WorldControls {
  /** 1, 0.1 (doll's house) or 5 (giant's eye). */
  scaleTo(scale: number): void;
  reset(): void;
}

export class PalettePanel extends Panel {
  private tab: Tab = 'labels';
  private first = 0;
  private readonly unfollow: () => void;

  constructor(private readonly world: WorldControls) {
    super({ width: 0.27, height: 0.33, pixelsPerMetre: 3600, em: 0.0115 }, 100);
    const { palette, counts, activeLabel: active, solo, tool, brush, view, undo, redo } = state;
    this.unfollow = watch(
      [palette, counts, active, solo, tool, brush, view, undo, redo, xrSettings],
      this.touch,
    );
  }

  override dispose(): void {
    this.unfollow();
    super.dispose();
  }

  protected override draw(ui: Ui): void {
    const { em, width } = ui;
    const pad = em * 0.6;
    const inner = width - 2 * pad;
    this.drawTabs(ui, pad, inner);
    const top = em * 3.2;
    if (this.tab === 'labels') this.drawLabels(ui, pad, top, inner);
    if (this.tab === 'tools') this.drawTools(ui, pad, top, inner);
    if (this.tab === 'view') this.drawView(ui, pad, top, inner);
    if (this.tab === 'new') this.drawNew(ui, pad, top, inner);
    this.drawHistory(ui, pad, inner);
  }

  private drawTabs(ui: Ui, x: number, inner: number): void {
    const tabs = [
      ['labels', 'Labels'],
      ['tools', 'Tools'],
      ['view', 'View'],
    ] as const;
    const w = inner / tabs.length;
    tabs.forEach(([tab, text], i) => {
      const on = this.tab === tab || (tab === 'labels' && this.tab === 'new');
      ui.button(x + i * w, ui.em * 0.5, w - ui.em * 0.2, ui.em * 2.2, { text, on }, () =>
        this.show(tab),
      );
    });
  }

  private show(tab: Tab): void {
    this.tab = tab;
    this.touch();
  }

  private drawLabels(ui: Ui, x: number, top: number, inner: number): void {
    const { em } = ui;
    const palette = state.palette.peek();
    this.first = Math.min(this.first, Math.max(0, palette.length - ROWS));
    const row = em * 2.35;
    palette.slice(this.first, this.first + ROWS).forEach((label, i) => {
      this.drawLabel(ui, label, x, top + i * row, inner, row - em * 0.15);
    });
    if (palette.length === 0) {
      ui.text('A label is one thing to follow.', x + em * 0.5, top + em * 1.5, {
        color: INK.quiet,
      });
    }
    const y = top + ROWS * row + em * 0.2;
    const w = inner / 4;
    ui.button(x, y, w * 1.4, em * 2.2, { icon: 'plus', text: 'New', strong: true }, () =>
      this.show('new'),
    );
    const picking = state.tool.peek() === 'pick';
    ui.button(
      x + w * 1.5,
      y,
      w * 1.3,
      em * 2.2,
      { icon: 'picker', text: 'Pick', on: picking },
      () => {
        actions.setTool(picking ? 'paint' : 'pick');
      },
    );
    const more = palette.length > ROWS;
    ui.button(x + w * 2.9, y, w * 0.52, em * 2.2, { icon: 'previous', disabled: !more }, () =>
      this.scroll(-ROWS),
    );
    ui.button(x + w * 3.45, y, w * 0.52, em * 2.2, { icon: 'next', disabled: !more }, () =>
      this.scroll(ROWS),
    );
  }

  private scroll(by: number): void {
    this.first = Math.max(0, this.first + by);
    this.touch();
  }

  private drawLabel(ui: Ui, label: Label, x: number, y: number, w: number, h: number): void {
    const { em } = ui;
    const on = label.id === state.activeLabel.peek();
    const tools = em * 4.6;
    ui.button(
      x,
      y,
      w - tools,
      h,
      { swatch: label.color, text: label.name, on, strong: true, align: 'left' },
      () => {
        actions.selectLabel(label.id);
        if (state.tool.peek() === 'pick') actions.setTool('paint');
      },
    );
    const left = x + w - tools + em * 0.15;
    const size = em * 1.45;
    const lock = { icon: label.locked ? 'lock' : 'unlock', on: label.locked } as const;
    const eye = { icon: label.visible ? 'eye' : 'hidden', on: !label.visible } as const;
    ui.button(left, y, size, h, lock, () => void actions.toggleLock(label.id));
    ui.button(left + size, y, size, h, eye, () => void actions.toggleVisible(label.id));
    const solo = state.solo.peek() === label.id;
    ui.button(left + 2 * size, y, size, h, { icon: 'solo', on: solo }, () =>
      actions.solo(solo ? null : label.id),
    );
  }

  /** Names without a keyboard: categories in use, then common ones; each counts on. */
  private drawNew(ui: Ui, x: number, top: number, inner: number): void {
    const { em } = ui;
    const palette = state.palette.peek();
    const names = palette.map((label) => label.name);
    const color = suggestColor(palette.map((label) => label.color));
    const used = palette.map((label) => label.category).filter(Boolean);
    const choices = [...new Set([...used, ...QUICK])].slice(0, 10);
    ui.text('What is it?', x + em * 0.4, top + em * 0.8, { color: INK.quiet });
    choices.forEach((category, i) => {
      const name = suggestName(category, names);
      const [column, line] = [i % 2, Math.floor(i / 2)];
      const w = inner / 2;
      ui.button(x + column * w, top + em * (1.9 + 2.4 * line), w - em * 0.25, em * 2.2,
        { swatch: color, text: name, strong: true, align: 'left' },
        () => {
          void actions.createLabel(name, color, category);
          actions.setTool('paint');
          this.show('labels');
        });
    }); // prettier-ignore
    ui.button(x, top + em * 14.4, inner / 3, em * 2.1, { text: 'Back', icon: 'previous' }, () =>
      this.show('labels'),
    );
  }

  private drawTools(ui: Ui, x: number, top: number, inner: number): void {
    const { em } = ui;
    const tool = state.tool.peek();
    const half = inner / 2;
    TOOLS.forEach(([id, icon, text], i) => {
      const [column, line] = [i % 2, Math.floor(i / 2)];
      ui.button(x + column * half, top + line * em * 2.3, half - em * 0.2, em * 2.1,
        { icon, text, on: tool === id, strong: true, align: 'left' }, () => actions.setTool(id));
    }); // prettier-ignore
    const way = currentWay();
    const third = inner / 3;
    WAYS.forEach(([id, icon, text], i) => {
      const [column, line] = [i % 3, Math.floor(i / 3)];
      ui.button(x + column * third, top + em * (5 + 2.3 * line), third - em * 0.2, em * 2.1,
        { icon, text, on: way === id, strong: true, align: 'left' }, () => chooseWay(id));
    }); // prettier-ignore
    const { radius, onlyUnlabeled, through } = state.brush.peek();
    const share = Math.log(radius / RADIUS_MIN) / Math.log(RADIUS_MAX / RADIUS_MIN);
    ui.slider(
      x + em * 0.4,
      top + em * 9.8,
      inner - em * 0.8,
      em * 2.8,
      'Radius',
      metres(radius),
      share,
      (to) => {
        actions.setRadius(RADIUS_MIN * (RADIUS_MAX / RADIUS_MIN) ** to);
      },
    );
    ui.check(x, top + em * 12.7, inner, em * 1.9, 'Only unlabeled points', onlyUnlabeled, (on) => {
      patch(state.brush, { onlyUnlabeled: on });
    });
    ui.check(x, top + em * 14.7, inner, em * 1.9, 'Ray goes through', through, (on) => {
      patch(state.brush, { through: on });
    });
  }

  private drawView(ui: Ui, x: number, top: number, inner: number): void {
    const { em } = ui;
    const view = state.view.peek();
    const left = x + em * 0.4;
    const wide = inner - em * 0.8;
    ui.slider(left, top, wide, em * 2.7, 'Labels over colour', `${Math.round(view.labelBlend * 100)} %`,
      view.labelBlend, (labelBlend) => actions.setView({ labelBlend })); // prettier-ignore
    ui.slider(left, top + em * 2.7, wide, em * 2.7, 'Point size', `${view.pointSize.toFixed(1)}×`,
      Math.log2(view.pointSize * 4) / 4, (to) => actions.setView({ pointSize: 2 ** (4 * to) / 4 })); // prettier-ignore
    ui.slider(left, top + em * 5.4, wide, em * 2.7, 'Brightness', `${view.brightness.toFixed(1)}×`,
      Math.log2(view.brightness * 4) / 4, (to) => actions.setView({ brightness: 2 ** (4 * to) / 4 })); // prettier-ignore
    const w = inner / 4;
    const scales = [
      ['1:1', 1],
      ['Doll', 0.1],
      ['Giant', 5],
    ] as const;
    scales.forEach(([text, scale], i) => {
      ui.button(x + i * w, top + em * 8.4, w - em * 0.2, em * 2, { text, strong: true }, () =>
        this.world.scaleTo(scale),
      );
    });
    ui.button(
      x + 3 * w,
      top + em * 8.4,
      w - em * 0.2,
      em * 2,
      { text: 'Reset', strong: true },
      () => this.world.reset(),
    );
    const { hand, move, vignette, seated, trail, tips } = xrSettings.peek();
    const half = inner / 2;
    const check = (
      column: number,
      line: number,
      name: string,
      on: boolean,
      set: (on: boolean) => void,
    ): void => {
      ui.check(x + column * half, top + em * (10.6 + 2 * line), half, em * 1.9, name, on, set);
    };
    check(0, 0, 'Left-handed', hand === 'left', (on) => change({ hand: on ? 'left' : 'right' }));
    check(1, 0, 'Glide', move === 'smooth', (on) => change({ move: on ? 'smooth' : 'teleport' }));
    check(0, 1, 'Seated', seated, (on) => change({ seated: on }));
    check(1, 1, 'Vignette', vignette, (on) => change({ vignette: on }));
    check(0, 2, 'Trail', trail, (on) => change({ trail: on }));
    check(1, 2, 'Button tips', tips, (on) => change({ tips: on }));
    ui.button(
      x + half,
      top + em * 16.9,
      half - em * 0.2,
      em * 2.1,
      { icon: 'exit', text: 'Leave', strong: true },
      () => {
        void actions.exitVR();
      },
    );
  }

  private drawHistory(ui: Ui, x: number, inner: number): void {
    const { em, height } = ui;
    const y = height - em * 5.1;
    const undo = state.undo.peek();
    const redo = state.redo.peek();
    ui.button(
      x,
      y,
      inner,
      em * 2.1,
      { icon: 'undo', text: undo ?? 'Nothing to undo', disabled: undo === null, align: 'left' },
      () => actions.undo(),
    );
    ui.button(
      x,
      y + em * 2.25,
      inner * 0.62,
      em * 2.1,
      { icon: 'redo', text: redo ?? 'Nothing to redo', disabled: redo === null, align: 'left' },
      () => actions.redo(),
    );
    const label = activeLabel.peek();
    const painted = label ? shortCount(state.counts.peek().get(label.id) ?? 0) : '';
    ui.text(painted ? `${painted} pts` : '', x + inner - em * 0.3, y + em * 3.3, {
      color: INK.quiet,
      align: 'right',
    });
  }
}

export function chooseWay(way: Way): void {
  if (way === 'fill' || way === 'lasso') {
    actions.setShape(way);
    return;
  }
  change({ tip: way });
  actions.setShape('brush');
}
