/** The tool for boxes under the mouse: a press chooses a box, or draws one where one is to be drawn. */
import { Vector3 } from 'three';
import { chooseBox } from '../boxes/changes';
import type { ObjectBoxes } from '../boxes/index';
import { boxMet } from '../boxes/met';
import { drawing, makeBox } from '../boxes/new';
import { DELETED } from '../cloud/points/piece';
import { actions } from '../store/actions';
import { FOLLOWS, picked } from '../store/boxes';
import { state } from '../store/state';
import { boxDraft } from '../tools/volume';
import type { Aim } from '../view/aim';
import type { BoxTool } from './box-tool';

/** Points are met within this of the cursor's ray, metres. */
const REACH = 0.06;
/** A box is met before points that are so far behind its surface, metres. */
const BEHIND = 0.3;

export class BoxPress {
  constructor(
    private readonly aim: Aim,
    private readonly objects: ObjectBoxes,
    private readonly tool: BoxTool,
  ) {}

  /** Begin to draw a box; false: the box under the cursor is chosen, and the view turns. */
  begin(): boolean {
    if (drawing.peek()) return this.tool.begin();
    this.choose();
    return false;
  }

  private choose(): void {
    const { origin, direction } = this.aim.ray();
    const hit = this.aim.hit(REACH);
    const label = hit?.frame.labelOf(hit.point) ?? 0;
    const within = hit ? hit.distance + BEHIND : Infinity;
    const box = boxMet(new Vector3(...origin), new Vector3(...direction), within);
    if (label !== 0 && label !== DELETED && label !== box?.label) {
      if (state.activeLabel.peek() !== label) actions.labels.selectLabel(label);
      picked.value = FOLLOWS;
    } else if (box) chooseBox(box);
  }

  /** The rectangle over the floor is drawn: it becomes a box. */
  end(): void {
    const drawn = this.tool.end();
    const volume = boxDraft.peek();
    if (!drawn || !volume || state.tool.peek() !== 'boxes') return;
    this.tool.drop();
    void makeBox(volume, this.objects.room, drawn.clicked);
  }
}
