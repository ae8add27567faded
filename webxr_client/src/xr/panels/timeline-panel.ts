/** The panel before one: time, strips, tracking. */
import { Mesh, MeshBasicMaterial, PlaneGeometry } from 'three';
import { actions } from '../../store/actions';
import { halted, stretch, unsure } from '../../engine/review';
import { frameRange } from '../../store/range';
import { state } from '../../store/state';
import { DARK_INK, drawTimeline } from '../../panels/timeline/draw';
import { doubtfulFrames } from '../../store/cells';
import { frameToX, xToFrame, type Span } from '../../panels/timeline/layout';
import { HANDLE_EMS, Panel } from './panel';
import { Readout } from './readout';
import { SIZES } from '../drawing/sizes';
import { questionOpen, drawTracking } from './timeline-tracking';
import { FONT, INK, type ButtonLook, type Ui } from '../drawing/ui';
import { watch } from '../../store/watch';

/** The panel is the back of the strips. */
const ON_GLASS = { ...DARK_INK, back: '#0000' } as const;
const SPEEDS = [0.25, 0.5, 1, 2];
const LANES = 5;
const GUTTER_EMS = 7.5;
const READOUT_EMS = 14.6;
/** To the right of the middle: a palette without a hand has its own to the left. */
const HANDLE = { at: 0.625, wide: 8.2 } as const;
/** Ems from the handle's left end to the number of the frame on it. */
const NUMBER_AT = 2.3;
/** Milliseconds between two drawings for deferred changes, as each drawing is costly. */
const SOON_MS = 100;
const LAZY_MS = 1000;

/** Ems of the row to carry the panel by. */
const BAR_EMS = 1.8;

export interface TimelineControls {
  /** It unfolds now. */
  opens(): void;
  hide(): void;
  /** Unfold the palette. */
  callPalette(): void;
}

export class TimelinePanel extends Panel {
  /** Moved in every frame, so that playing does not draw the panel anew. */
  private readonly head: Mesh<PlaneGeometry, MeshBasicMaterial>;
  private readonly span: { first: number; length: number } = { first: 0, length: 1 };
  private readonly unsubscribe: () => void;
  private offered = -1;
  private strips = { x: 0, y: 0, w: 1, h: 1 };
  private readonly readout: Readout;
  /** Its beginning, metres, and that on the handle. */
  private readonly readoutAt: readonly [number, number];
  private readonly numberAt: readonly [number, number];
  /** Whether a deferred value changed: loaded frames, or the progress of a run. */
  private stale = false;
  private drawnAt = -Infinity;

  constructor(private readonly controls: TimelineControls) {
    super(
      {
        width: 1.06,
        height: 0.505,
        pixelsPerMetre: 1600,
        em: SIZES.timeline.em,
        handle: HANDLE,
      },
      90,
    );
    const material = new MeshBasicMaterial({
      color: 0xffffff,
      depthWrite: false,
      transparent: true,
    });
    this.head = new Mesh(new PlaneGeometry(1, 1), material);
    this.head.renderOrder = 91;
    this.head.frustumCulled = false;
    this.mesh.add(this.head);
    const { width, height, em, pixelsPerMetre } = this.size;
    this.readout = new Readout(this.ui.em, pixelsPerMetre, 91);
    this.readout.lieOn(this.mesh);
    this.readoutAt = [READOUT_EMS * em - width / 2, height / 2 - 1.6 * em];
    const handle = (HANDLE.at - 0.5) * width - (HANDLE.wide / 2) * em;
    this.numberAt = [handle + NUMBER_AT * em, (HANDLE_EMS / 2) * em - height / 2];
    const { sequence, playing, speed, loop, palette, timeline, loaded, activeLabel, jobs } = state;
    const soon = watch(
      [
        sequence,
        playing,
        speed,
        loop,
        palette,
        activeLabel,
        frameRange,
        halted,
        unsure,
        stretch,
        questionOpen,
      ],
      this.touch,
    );
    const later = watch([loaded, timeline, jobs], () => (this.stale = true));
    this.unsubscribe = () => {
      soon();
      later();
    };
  }

  override dispose(): void {
    this.unsubscribe();
    this.readout.dispose();
    this.head.geometry.dispose();
    this.head.material.dispose();
    super.dispose();
  }

  override setFolded(folded: boolean): void {
    if (this.folded && !folded) this.controls.opens();
    super.setFolded(folded);
  }

  override update(now: number): void {
    const frame = state.frame.peek();
    const playing = state.playing.peek();
    // The offers of the row below depend on the frame; they are not updated during playback.
    if (!playing && frame !== this.offered) {
      this.offered = frame;
      this.touch();
    }
    if (this.stale && now - this.drawnAt > (playing ? LAZY_MS : SOON_MS)) {
      this.stale = false;
      this.drawnAt = now;
      this.touch();
    }
    this.placeHead(frame);
    this.readout.update(this.folded ? this.numberAt : this.readoutAt, this.folded);
    super.update(now);
  }

  private placeHead(frame: number): void {
    const { width, height, pixelsPerMetre } = this.size;
    const { x, y, w, h } = this.strips;
    const at = (x + frameToX(frame + 0.5, this.span, w)) / pixelsPerMetre;
    this.head.position.set(at - width / 2, height / 2 - (y + h / 2) / pixelsPerMetre, 0.001);
    this.head.scale.set(0.0025, h / pixelsPerMetre, 1);
    this.head.visible = !this.folded && state.sequence.peek() !== null;
  }

  /** The number of the frame lies beside the icon. */
  protected override handleLook(): ButtonLook {
    return { icon: 'frames', align: 'left' };
  }

  protected override draw(ui: Ui): void {
    this.drawBar(ui);
    const info = state.sequence.peek();
    if (!info) {
      ui.text('Open a recording at the desk.', ui.width / 2, ui.height / 2, { align: 'center' });
      return;
    }
    this.drawTransport(ui, info.frames);
    this.drawStrips(ui, info.frames);
    drawTracking(ui, info.frames, ui.height - (BAR_EMS + 3) * ui.em);
  }

  /** Bottom row: the bar to carry the panel, and buttons to show the palette and hide this panel. */
  private drawBar(ui: Ui): void {
    const { em, width, height } = ui;
    const [y, h] = [height - (BAR_EMS + 0.2) * em, BAR_EMS * em];
    const side = 6.5 * em;
    const { controls } = this;
    ui.button(em * 0.5, y, side, h, { text: 'Palette' }, () => controls.callPalette());
    ui.button(width - side - em * 0.5, y, side, h, { icon: 'close', text: 'Hide' }, () =>
      controls.hide(),
    );
    const [x, w] = [side + em, width - 2 * (side + em)];
    ui.area({ name: 'Move', x, y, w, h, moves: true });
    ui.box(x + w * 0.3, y + h * 0.4, w * 0.4, h * 0.2, INK.off);
  }

  private drawTransport(ui: Ui, frames: number): void {
    const { em } = ui;
    const h = em * 2.3;
    const y = em * 0.45;
    const playing = state.playing.peek();
    let x = em * 0.5;
    const icon = (name: Parameters<Ui['icon']>[0], act: () => void, on = false): void => {
      ui.button(x, y, em * 2.3, h, { icon: name, on, strong: true }, act);
      x += em * 2.5;
    };
    icon('back', () => actions.time.step(-1));
    icon(playing ? 'pause' : 'play', () => actions.time.togglePlay(), playing);
    icon('forward', () => actions.time.step(1));
    icon('loop', () => actions.time.toggleLoop(), state.loop.peek());
    const speed = state.speed.peek();
    ui.button(x, y, em * 3.2, h, { text: `${speed}×`, strong: true }, () => {
      actions.time.setSpeed(SPEEDS[(SPEEDS.indexOf(speed) + 1) % SPEEDS.length]!);
    });
    const doubtful = doubtfulFrames(state.timeline.peek().rows.values(), frames).length;
    if (doubtful === 0) return;
    const right = ui.width - em * 0.5;
    ui.button(right - em * 2.2, y, em * 2.2, h, { icon: 'next', strong: true }, () =>
      actions.time.nextDoubtful(1),
    );
    ui.text(`${doubtful} doubtful`, right - em * 5.6, y + h / 2, {
      color: INK.warn,
      align: 'center',
    });
    ui.button(right - em * 11.2, y, em * 2.2, h, { icon: 'previous', strong: true }, () =>
      actions.time.nextDoubtful(-1),
    );
  }

  private drawStrips(ui: Ui, frames: number): void {
    const { em, pen } = ui;
    const top = em * 3.2;
    const ruler = em * 1.9;
    const row = em * 1.75;
    const gutter = em * GUTTER_EMS;
    const width = ui.width - em;
    const height = ruler + LANES * row;
    this.span.length = frames;
    const span: Span = this.span;
    const { rows } = state.timeline.peek();
    const active = state.activeLabel.peek();
    const labels = state.palette
      .peek()
      .filter((label) => rows.has(label.id) || label.id === active);
    const place = labels.findIndex((label) => label.id === active);
    const scroll = Math.max(0, Math.min(place - LANES + 2, labels.length - LANES));
    pen.save();
    pen.translate(em * 0.5, top);
    drawTimeline(
      pen,
      { width, height, gutter, ruler, row, font: FONT, fontSize: em, ink: ON_GLASS },
      { span, frames, frame: null, loaded: state.loaded.peek(), range: frameRange.peek(), labels, rows, active, scroll },
    ); // prettier-ignore
    pen.restore();
    const x = em * 0.5 + gutter;
    const w = width - gutter;
    this.strips = { x, y: top, w, h: height };
    const seek = (share: number): void =>
      actions.time.seek(xToFrame(share * w, span, w, frames), true);
    ui.area({ name: 'ruler', x, y: top, w, h: ruler, act: seek, drag: seek, plain: true });
    let start = 0;
    ui.area({
      name: 'strips',
      x, y: top + ruler, w, h: height - ruler, plain: true,
      act: (share) => {
        start = xToFrame(share * w, span, w, frames);
        frameRange.value = null;
        seek(share);
      },
      drag: (share) => {
        const to = xToFrame(share * w, span, w, frames);
        frameRange.value = to === start ? null : { from: start, to };
      },
    }); // prettier-ignore
  }
}
