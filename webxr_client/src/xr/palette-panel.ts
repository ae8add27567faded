/** The panel on the other hand: labels, tools, view. */
import { actions } from '../actions';
import { unsure } from '../engine/review';
import { state } from '../state';
import { Glow } from './glow';
import { SystemKeyboard } from './keyboard';
import { LabelsPage, ROWS } from './pages/labels';
import { floorPlaces } from '../engine/floor';
import { drawComfort } from './pages/comfort';
import { drawFloor } from './pages/floor';
import { drawNew } from './pages/new-label';
import { drawTools, offered } from './pages/tools';
import { drawView, type WorldControls } from './pages/view';
import { Panel } from './panel';
import { xrSettings } from './settings';
import { SIZES } from './sizes';
import type { Ui } from './ui';
import { watch } from '../watch';

type Tab = 'labels' | 'tools' | 'view' | 'comfort' | 'new';

const TABS = [
  ['labels', 'Labels'],
  ['tools', 'Tools'],
  ['view', 'View'],
  ['comfort', 'Comfort'],
] as const;

export interface PaletteControls extends WorldControls {
  /** Put the palette away. */
  putAway(): void;
  toggleTimeline(): void;
}

export class PalettePanel extends Panel {
  private tab: Tab = 'labels';
  private readonly labels = new LabelsPage(this.touch, () => this.show('new'));
  private readonly glow = new Glow(ROWS);
  private readonly keyboard: SystemKeyboard;
  private readonly unfollow: () => void;

  constructor(
    private readonly controls: PaletteControls,
    session: XRSession,
  ) {
    super({ width: 0.31, height: 0.379, pixelsPerMetre: 3135, em: SIZES.palette.em }, 100);
    this.keyboard = new SystemKeyboard(session);
    this.mesh.add(this.glow.mesh);
    const { palette, counts, activeLabel: active, solo, tool, brush, view, undo, redo } = state;
    this.unfollow = watch(
      [
        palette,
        counts,
        active,
        solo,
        tool,
        brush,
        view,
        undo,
        redo,
        unsure,
        floorPlaces,
        offered,
        xrSettings,
      ],
      this.touch,
    );
  }

  override dispose(): void {
    this.unfollow();
    this.keyboard.close();
    this.glow.dispose();
    super.dispose();
  }

  /** How brightly the labels glow that a person should look at, 0..1. */
  pulse(strength: number): void {
    this.glow.pulse(this.tab === 'labels' ? strength : 0);
  }

  protected override draw(ui: Ui): void {
    const { em, width } = ui;
    const pad = em * 0.6;
    const inner = width - 2 * pad;
    this.drawTabs(ui, pad, inner);
    this.drawPage(ui, pad, em * 3.2, inner);
    this.drawHistory(ui, pad, inner);
    this.placeGlow(pad, inner);
  }

  private drawPage(ui: Ui, x: number, top: number, inner: number): void {
    if (state.tool.peek() === 'floor') drawFloor(ui, x, top, inner);
    else if (this.tab === 'labels') this.labels.draw(ui, x, top, inner);
    else if (this.tab === 'tools') drawTools(ui, x, top, inner);
    else if (this.tab === 'view') drawView(ui, x, top, inner, this.controls);
    else if (this.tab === 'comfort') drawComfort(ui, x, top, inner);
    else drawNew(ui, x, top, inner, this.keyboard, () => this.show('labels'));
  }

  private drawTabs(ui: Ui, x: number, inner: number): void {
    const w = inner / TABS.length;
    TABS.forEach(([tab, text], i) => {
      const on = this.tab === tab || (tab === 'labels' && this.tab === 'new');
      ui.button(x + i * w, ui.em * 0.5, w - ui.em * 0.2, ui.em * 2.2, { text, on }, () =>
        this.show(tab),
      );
    });
  }

  private show(tab: Tab): void {
    this.tab = tab;
    if (state.tool.peek() === 'floor') actions.setTool('paint');
    this.touch();
  }

  /** A light over each row whose label is doubtful in this frame. */
  private placeGlow(x: number, inner: number): void {
    const { top, row } = this.labels;
    const { width, height, pixelsPerMetre } = this.size;
    const rows = unsure.peek().flatMap((label) => {
      const place = this.labels.rowOf(label);
      return place < 0 ? [] : place;
    });
    this.glow.place(
      rows.map((place) => ({
        x: (x + inner / 2) / pixelsPerMetre - width / 2,
        y: height / 2 - (top + (place + 0.47) * row) / pixelsPerMetre,
        width: inner / pixelsPerMetre,
        height: row / pixelsPerMetre,
      })),
    );
  }

  /** Below every page: undo and redo, and what shows the timeline and hides the palette. */
  private drawHistory(ui: Ui, x: number, inner: number): void {
    const { em, height } = ui;
    const [undo, redo] = [state.undo.peek(), state.redo.peek()];
    const wide = inner * 0.62;
    const [left, side] = [x + wide + em * 0.25, inner - wide - em * 0.25];
    const upper = height - em * 5.1;
    const lower = upper + em * 2.25;
    const h = em * 2.1;
    const past = { icon: 'undo', text: undo ?? 'Nothing to undo', align: 'left' } as const;
    ui.button(x, upper, wide, h, { ...past, disabled: undo === null }, () => actions.undo());
    const future = { icon: 'redo', text: redo ?? 'Nothing to redo', align: 'left' } as const;
    ui.button(x, lower, wide, h, { ...future, disabled: redo === null }, () => actions.redo());
    const { controls } = this;
    const aside = { strong: true, align: 'left' } as const;
    ui.button(left, upper, side, h, { icon: 'frames', text: 'Timeline', ...aside }, () =>
      controls.toggleTimeline(),
    );
    ui.button(left, lower, side, h, { icon: 'hidden', text: 'Put away', ...aside }, () =>
      controls.putAway(),
    );
  }
}
