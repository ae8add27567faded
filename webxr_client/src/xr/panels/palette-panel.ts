/** The panel on the other hand: labels, tools, view. */
import type { IconName } from '../../common/icons';
import { actions } from '../../store/actions';
import { aligning } from '../../engine/align-sensors';
import { unsure } from '../../engine/review';
import { limits } from '../../store/limits';
import { activeLabel, state } from '../../store/state';
import { Glow } from '../drawing/glow';
import { type AskName, LettersPage, SystemKeyboard } from './pages/writing';
import { CHIPS, LabelsPage } from './pages/labels';
import { floorPlaces } from '../../engine/floor';
import { drawComfort } from './pages/comfort';
import { drawNew, EditPage } from './pages/label';
import { BOXES, drawBoxes } from './pages/boxes';
import { drawExample, EXAMPLE } from './pages/example';
import { drawFloor } from './pages/floor';
import { RecordingsPage } from './pages/recordings';
import { SensorsPage } from './pages/sensors';
import { drawTools, offered } from './pages/tools';
import { drawWork, WORK } from './pages/work';
import { drawView, type WorldControls } from './pages/view';
import { Panel } from './panel';
import { roomWay } from '../../tools/ways';
import { hiddenSensors } from '../../store/sensors';
import { xrSettings } from '../../store/xr-settings';
import { SIZES } from '../drawing/sizes';
import type { ButtonLook, Entry, Ui } from '../drawing/ui';
import { watch } from '../../store/watch';
import { openWork } from '../../work/store';

type Tab = 'labels' | 'tools' | 'boxes' | 'example' | 'work' | 'view' | 'comfort';
/** Pages that a tab leads on to. */
type Page = Tab | 'new' | 'edit' | 'letters' | 'note' | 'recordings' | 'sensors';

/** In groups: labels and points, objects and tasks, the person. */
const TABS: readonly (readonly (readonly [Tab, IconName, string])[])[] = [
  [
    ['labels', 'layers', 'Labels'],
    ['tools', 'brush', 'Tools'],
    ['view', 'eye', 'View'],
  ],
  [
    ['boxes', 'box', 'Fit boxes'],
    ['example', 'example', 'Teach'],
    ['work', 'check', 'Work'],
  ],
  [['comfort', 'headset', 'Comfort']],
];
/** Ems of the strip of tabs: its width, the height of a tab, and below a group. */
const [RAIL, TAB, GAP] = [5.3, 2.9, 0.4];

/** The tab that a page is reached from. */
function tabOf(page: Page): Tab {
  if (page === 'recordings' || page === 'sensors') return 'view';
  if (page === 'note') return 'work';
  return page === 'new' || page === 'edit' || page === 'letters' ? 'labels' : page;
}

export interface PaletteControls extends WorldControls {
  /** Put the palette away. */
  foldPalette(): void;
  toggleTimeline(): void;
}

export class PalettePanel extends Panel {
  private page: Page = 'labels';
  private readonly labels = new LabelsPage(
    this.touch,
    () => this.show('new'),
    () => this.change(),
  );
  private readonly letters = new LettersPage(this.touch, () => this.show(tabOf(this.page)));
  private readonly ask: AskName = (question, take) => {
    if (this.keyboard.supported) {
      this.keyboard.ask(question, take);
      return;
    }
    this.letters.ask(question, take);
    this.show(this.page === 'work' ? 'note' : 'letters');
  };
  private readonly edit = new EditPage(this.touch, this.ask, () => this.show('labels'));
  private readonly recordings = new RecordingsPage(this.touch, () => this.show('view'));
  private readonly sensors = new SensorsPage(this.touch, () => this.show('view'));
  private readonly glow = new Glow(CHIPS);
  private readonly keyboard: SystemKeyboard;
  private readonly unsubscribe: () => void;

  constructor(
    private readonly controls: PaletteControls,
    session: XRSession,
  ) {
    super(
      {
        width: 0.345,
        height: 0.362,
        pixelsPerMetre: 3100,
        em: SIZES.palette.em,
        // To the right, where no hints of a left hand are, and clear of the timeline's handle.
        handle: { at: 0.745, wide: 9 },
      },
      100,
    );
    this.keyboard = new SystemKeyboard(session);
    this.mesh.add(this.glow.mesh);
    const { palette, counts, activeLabel: active, solo, tool, brush, view, undo, redo } = state;
    const { sequence, sequences } = state;
    this.unsubscribe = watch(
      [
        sequence,
        sequences,
        limits,
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
        hiddenSensors,
        aligning,
        floorPlaces,
        offered,
        xrSettings,
        ...EXAMPLE,
        ...BOXES,
        ...WORK,
      ],
      this.touch,
    );
  }

  override dispose(): void {
    this.unsubscribe();
    this.edit.dispose();
    this.keyboard.close();
    this.glow.dispose();
    super.dispose();
  }

  /** Brightness, of labels that a person should look at, 0..1. */
  pulse(strength: number): void {
    this.glow.pulse(!this.folded && this.page === 'labels' ? strength : 0);
  }

  /** The active label with the shape of the brush; without a label, the panel's name. */
  protected override handleLook(): ButtonLook {
    const label = activeLabel.peek();
    const { icon } = roomWay();
    return label ? { swatch: label.color, icon, text: label.name } : { text: 'Palette' };
  }

  protected override draw(ui: Ui): void {
    const { em, width } = ui;
    const pad = em * 0.6;
    const left = (RAIL + 0.5) * em + pad;
    this.drawTabs(ui, pad, pad);
    this.drawPage(ui, left, pad, width - pad - left);
    this.drawHistory(ui, pad, width - 2 * pad);
    this.placeGlow();
  }

  private drawPage(ui: Ui, x: number, top: number, inner: number): void {
    if (state.tool.peek() === 'floor') drawFloor(ui, x, top, inner);
    else this.pages[this.page](ui, x, top, inner);
  }

  private readonly pages: Readonly<
    Record<Page, (ui: Ui, x: number, top: number, inner: number) => void>
  > = {
    labels: (...place) => this.labels.draw(...place),
    tools: drawTools,
    boxes: drawBoxes,
    example: drawExample,
    work: (...place) => drawWork(...place, this.ask),
    view: (...place) => drawView(...place, this.controls, (page) => this.show(page)),
    comfort: drawComfort,
    new: (...place) => drawNew(...place, this.ask, () => this.show('labels')),
    edit: (...place) => {
      const label = activeLabel.peek();
      if (label) this.edit.draw(...place, label);
      else this.labels.draw(...place);
    },
    letters: (...place) => this.letters.draw(...place),
    note: (...place) => this.letters.draw(...place),
    recordings: (...place) => this.recordings.draw(...place),
    sensors: (...place) => this.sensors.draw(...place),
  };

  private change(): void {
    this.edit.begin();
    this.show('edit');
  }

  private drawTabs(ui: Ui, x: number, top: number): void {
    const { em } = ui;
    let y = top;
    // A task of a study has neither boxes nor the work of a project.
    for (const group of TABS.filter((_, i) => i !== 1 || !limits.peek())) {
      const entries = group.map(([tab, icon, text]): Entry => {
        return [{ icon, text, on: tabOf(this.page) === tab }, () => this.show(tab)];
      });
      ui.strip(x, y, RAIL * em, TAB * em, entries, 1);
      y += (TAB * group.length + GAP) * em;
    }
  }

  private show(page: Page): void {
    this.page = page;
    // The tasks are kept up to date while the desk's own list of them is open.
    if (page === 'work') openWork('tasks');
    if (page === 'recordings') void actions.recordings.refreshSequences();
    if (state.tool.peek() === 'floor') actions.tools.setTool('paint');
    this.touch();
  }

  /** Place a light over the chip of each uncertain label of this frame. */
  private placeGlow(): void {
    const { width, height, pixelsPerMetre } = this.size;
    const chips = unsure.peek().flatMap((label) => this.labels.chips.get(label) ?? []);
    this.glow.place(
      chips.map(({ x, y, w, h }) => ({
        x: (x + w / 2) / pixelsPerMetre - width / 2,
        y: height / 2 - (y + h / 2) / pixelsPerMetre,
        width: w / pixelsPerMetre,
        height: h / pixelsPerMetre,
      })),
    );
  }

  /** Below every page: undo and redo, and buttons to show the timeline and hide the palette. */
  private drawHistory(ui: Ui, x: number, inner: number): void {
    const { em, height } = ui;
    const [undo, redo] = [state.undo.peek(), state.redo.peek()];
    const wide = inner * 0.62;
    const [left, side] = [x + wide + em * 0.25, inner - wide - em * 0.25];
    const upper = height - em * 5.1;
    const lower = upper + em * 2.25;
    const h = em * 2.1;
    const past = { icon: 'undo', text: undo ?? 'Nothing to undo', align: 'left' } as const;
    ui.button(x, upper, wide, h, { ...past, disabled: undo === null }, () =>
      actions.history.undo(),
    );
    const future = { icon: 'redo', text: redo ?? 'Nothing to redo', align: 'left' } as const;
    ui.button(x, lower, wide, h, { ...future, disabled: redo === null }, () =>
      actions.history.redo(),
    );
    const { controls } = this;
    const aside = { strong: true, align: 'left' } as const;
    ui.button(left, upper, side, h, { icon: 'frames', text: 'Timeline', ...aside }, () =>
      controls.toggleTimeline(),
    );
    ui.button(left, lower, side, h, { icon: 'hidden', text: 'Put away', ...aside }, () =>
      controls.foldPalette(),
    );
  }
}
