/** The panel before one: time, strips, tracking. */
import { Mesh, MeshBasicMaterial, PlaneGeometry } from 'three';
import { actions } from '../actions';
import { state, trackingJob } from '../state';
import { clock } from '../panels/format';
import { frameRange, ordered } from '../panels/range';
import { drawTimeline } from '../panels/timeline-draw';
import { doubtfulFrames, frameToX, xToFrame, type Span } from '../panels/timeline-layout';
import { Panel } from './panel';
import { watch } from './watch';
import { FONT, INK, type Ui } from './ui';

const SPEEDS = [0.25, 0.5, 1, 2];
const LANES = 4;
const GUTTER_EMS = 7.5;

export class TimelinePanel extends Panel {
  /** Moved in every frame, so that playing does not draw the panel anew. */
  private readonly head: Mesh<PlaneGeometry, MeshBasicMaterial>;
  private readonly span: { first: number; length: number } = { first: 0, length: 1 };
  private readonly unfollow: () => void;
  private strips = { x: 0, y: 0, w: 1, h: 1 };
  private readout = -1;
  private readoutAt = 0;

  constructor() {
    super({ width: 0.9, height: 0.43, pixelsPerMetre: 1800, em: 0.02 }, 90);
    const material = new MeshBasicMaterial({
      color: 0xffffff,
      depthTest: false,
      transparent: true,
    });
    this.head = new Mesh(new PlaneGeometry(1, 1), material);
    this.head.renderOrder = 91;
    this.head.frustumCulled = false;
    this.mesh.add(this.head);
    const { sequence, playing, speed, loop, palette, timeline, loaded, activeLabel, jobs } = state;
    this.unfollow = watch(
      [sequence, playing, speed, loop, palette, timeline, loaded, activeLabel, jobs, frameRange],
      this.touch,
    );
  }

  override dispose(): void {
    this.unfollow();
    this.head.geometry.dispose();
    this.head.material.dispose();
    super.dispose();
  }

  override update(now: number): void {
    const frame = state.frame.peek();
    // The number may lag a little while it plays.
    const pause = state.playing.peek() ? 250 : 0;
    if (frame !== this.readout && now - this.readoutAt > pause) {
      this.readout = frame;
      this.readoutAt = now;
      this.touch();
    }
    this.placeHead(frame);
    super.update(now);
  }

  private placeHead(frame: number): void {
    const { width, height, pixelsPerMetre } = this.size;
    const { x, y, w, h } = this.strips;
    const at = (x + frameToX(frame + 0.5, this.span, w)) / pixelsPerMetre;
    this.head.position.set(at - width / 2, height / 2 - (y + h / 2) / pixelsPerMetre, 0.001);
    this.head.scale.set(0.0025, h / pixelsPerMetre, 1);
    this.head.visible = state.sequence.peek() !== null;
  }

  protected override draw(ui: Ui): void {
    const info = state.sequence.peek();
    if (!info) {
      ui.text('Open a recording at the desk.', ui.width / 2, ui.height / 2, { align: 'center' });
      return;
    }
    this.drawTransport(ui, info.frames, info.fps);
    this.drawStrips(ui, info.frames);
    this.drawTracking(ui, info.frames);
  }

  private drawTransport(ui: Ui, frames: number, fps: number): void {
    const { em } = ui;
    const h = em * 2.3;
    const y = em * 0.45;
    const playing = state.playing.peek();
    let x = em * 0.5;
    const icon = (name: Parameters<Ui['icon']>[0], act: () => void, on = false): void => {
      ui.button(x, y, em * 2.3, h, { icon: name, on, strong: true }, act);
      x += em * 2.5;
    };
    icon('back', () => actions.step(-1));
    icon(playing ? 'pause' : 'play', () => actions.togglePlay(), playing);
    icon('forward', () => actions.step(1));
    icon('loop', () => actions.toggleLoop(), state.loop.peek());
    const speed = state.speed.peek();
    ui.button(x, y, em * 3.2, h, { text: `${speed}×`, strong: true }, () => {
      actions.setSpeed(SPEEDS[(SPEEDS.indexOf(speed) + 1) % SPEEDS.length]!);
    });
    x += em * 3.8;
    const frame = state.frame.peek();
    ui.text(`${frame} / ${frames - 1}`, x, y + h / 2, { size: 1.2, weight: 600 });
    ui.text(clock(frame / Math.max(fps, 1e-3)), x + em * 6.4, y + h / 2, { color: INK.quiet });
    const doubtful = doubtfulFrames(state.timeline.peek().rows.values(), frames).length;
    if (doubtful === 0) return;
    const right = ui.width - em * 0.5;
    ui.button(right - em * 2.2, y, em * 2.2, h, { icon: 'next', strong: true }, () =>
      actions.nextDoubtful(1),
    );
    ui.text(`${doubtful} doubtful`, right - em * 5.6, y + h / 2, {
      color: '#ffc966',
      align: 'center',
    });
    ui.button(right - em * 11.2, y, em * 2.2, h, { icon: 'previous', strong: true }, () =>
      actions.nextDoubtful(-1),
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
      { width, height, gutter, ruler, row, font: FONT, fontSize: em },
      { span, frames, frame: null, loaded: state.loaded.peek(), range: frameRange.peek(), labels, rows, active, scroll },
    ); // prettier-ignore
    pen.restore();
    const x = em * 0.5 + gutter;
    const w = width - gutter;
    this.strips = { x, y: top, w, h: height };
    const seek = (share: number): void => actions.seek(xToFrame(share * w, span, w, frames), true);
    ui.area({ name: 'ruler', x, y: top, w, h: ruler, act: seek, drag: seek });
    let start = 0;
    ui.area({
      name: 'strips',
      x, y: top + ruler, w, h: height - ruler,
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

  private drawTracking(ui: Ui, frames: number): void {
    const { em, width, height } = ui;
    const y = height - em * 2.9;
    const h = em * 2.4;
    const job = trackingJob.peek();
    if (job) {
      ui.text(`Tracking ${Math.round(job.progress * 100)} %`, em * 0.8, y + h / 2, { weight: 600 });
      ui.box(em * 10, y + h / 2 - em * 0.2, em * 14, em * 0.4, INK.line);
      ui.box(
        em * 10,
        y + h / 2 - em * 0.2,
        em * 14 * Math.max(0.02, job.progress),
        em * 0.4,
        INK.accent,
      );
      ui.button(
        width - em * 21,
        y,
        em * 12,
        h,
        { text: 'Stop and keep', icon: 'check', strong: true },
        () => void actions.cancelJob(job.id, true),
      );
      ui.button(
        width - em * 8.5,
        y,
        em * 8,
        h,
        { text: 'Cancel', icon: 'close', strong: true },
        () => void actions.cancelJob(job.id),
      );
      return;
    }
    const range = frameRange.peek();
    const frame = state.frame.peek();
    const labels = trackable(range?.from ?? frame);
    const what = labels.length === 1 ? 'label' : 'labels';
    const off = labels.length === 0;
    const name = off
      ? 'Paint something, then track it'
      : `Track ${labels.length} ${what} of frame ${range?.from ?? frame}`;
    ui.text(name, em * 0.8, y + h / 2, { color: off ? INK.quiet : INK.text, width: em * 15.5 });
    const track = (stop: number): void => {
      actions.track({
        labels,
        start: range?.from ?? frame,
        stop,
        method: 'auto',
        overwrite: 'tracked',
      });
    };
    if (range) {
      const [from, to] = ordered(range);
      ui.button(
        width - em * 22,
        y,
        em * 14,
        h,
        { icon: 'track', text: `Frames ${from} – ${to}`, on: true, disabled: off },
        () => track(range.to),
      );
      ui.button(
        width - em * 7.5,
        y,
        em * 7,
        h,
        { icon: 'close', text: 'Range' },
        () => (frameRange.value = null),
      );
      return;
    }
    const back = off || frame === 0;
    const on = off || frame === frames - 1;
    ui.button(
      width - em * 30,
      y,
      em * 9.4,
      h,
      { icon: 'previous', text: 'To start', strong: true, disabled: back },
      () => track(0),
    );
    ui.button(
      width - em * 20.3,
      y,
      em * 10.2,
      h,
      { icon: 'track', text: '30 frames', strong: true, disabled: on },
      () => track(Math.min(frames - 1, frame + 30)),
    );
    ui.button(
      width - em * 9.8,
      y,
      em * 9.3,
      h,
      { icon: 'next', text: 'To end', strong: true, disabled: on },
      () => track(frames - 1),
    );
  }
}

/** The active label if it is in the frame, else every unlocked one that is. */
function trackable(frame: number): number[] {
  const { rows } = state.timeline.peek();
  const here = state.palette
    .peek()
    .filter((label) => !label.locked && (rows.get(label.id)?.points[frame] ?? 0) > 0)
    .map((label) => label.id);
  const active = state.activeLabel.peek();
  return here.includes(active) ? [active] : here;
}
