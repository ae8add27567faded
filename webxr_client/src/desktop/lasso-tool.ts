/** The lasso tool at the desk: its outline, and the stroke that it makes. */
import { state } from '../store/state';
import type { AheadPreview } from '../tools/preview';
import { brushFor, brushNow } from '../tools/brush';
import { LassoOutline } from '../tools/lasso';
import type { Strokes } from '../tools/strokes';
import { deskWay } from '../tools/ways';
import type { Aim } from '../view/aim';

export interface LassoToolDeps {
  readonly aim: Aim;
  readonly strokes: Strokes;
  readonly ahead: AheadPreview;
}

export class LassoTool {
  readonly outline: LassoOutline;

  constructor(
    canvas: HTMLCanvasElement,
    private readonly deps: LassoToolDeps,
  ) {
    this.outline = new LassoOutline(canvas);
  }

  /** Before each picture: show the points inside the outline while it is drawn. */
  update(): void {
    if (!this.outline.changed) return;
    this.outline.changed = false;
    const { aim, ahead } = this.deps;
    const polygon = this.outline.outline();
    const frame = aim.frame();
    const info = state.sequence.peek();
    const brush = brushNow(deskWay(), state.brush.peek().radius);
    if (!polygon || !frame || !info || !brush) ahead.hide();
    else ahead.show(frame, { ...brush, polygon, matrix: aim.clipFromSource(info) });
  }

  /** Take the points that the outline encloses. */
  end(): void {
    const { aim, ahead, strokes } = this.deps;
    const polygon = this.outline.end();
    ahead.hide();
    const frame = aim.frame();
    const info = state.sequence.peek();
    const brush = polygon && brushFor(deskWay(), state.brush.peek().radius);
    if (!polygon || !frame || !info || !brush) return;
    const stroke = { ...brush, polygon, matrix: aim.clipFromSource(info) };
    strokes.begin(frame, stroke, info.shift).end();
  }
}
