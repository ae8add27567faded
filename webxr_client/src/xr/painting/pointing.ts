/** Tools with which the hand points at something once: the picker, the floor's, and the one for boxes. */
import { Vector3 } from 'three';
import { DELETED } from '../../cloud/points/piece';
import type { Engine } from '../../engine/engine';
import { actions } from '../../store/actions';
import { state } from '../../store/state';
import { peek } from '../../store/watch';
import { BoxGrab, type HandAt } from './box-grab';
import type { BrushLook } from './brush-look';
import type { Place } from './place';
import type { Pointer } from '../input/pointer';

const PICK_RADIUS = 0.03;

export class Pointing {
  private readonly boxes = new BoxGrab();

  constructor(
    private readonly engine: Engine,
    private readonly place: Place,
    private readonly look: BrushLook,
    private readonly pulse: (strength: number, milliseconds: number) => void,
  ) {}

  /** The trigger went down with a tool that points. */
  begin(hand: Pointer, tip: Vector3): void {
    const tool = peek(state.tool);
    if (tool === 'pick') this.pick(hand);
    if (tool === 'boxes' && this.boxes.begin(this.handAt(hand, tip))) this.pulse(0.5, 30);
    if (tool !== 'floor') return;
    const { origin, direction } = this.handAt(hand, tip);
    void actions.view.pointAtFloor({ origin: origin.toArray(), direction: direction.toArray() });
    this.pulse(0.5, 30);
  }

  /** Let a box that is held follow the hand; false when none is. */
  move(hand: Pointer, tip: Vector3): boolean {
    if (!this.boxes.holds) return false;
    this.boxes.move(this.handAt(hand, tip));
    return true;
  }

  end(): void {
    this.boxes.end();
  }

  private handAt(hand: Pointer, tip: Vector3): HandAt {
    const { place } = this;
    return {
      tip: place.toLocal(tip, new Vector3()),
      origin: place.toLocal(hand.origin, new Vector3()),
      direction: place.directionToLocal(hand.direction, new Vector3()),
      far: hand.reach === 'far',
      scale: place.scale,
    };
  }

  private pick(hand: Pointer): void {
    const hit = this.look.hit(hand, PICK_RADIUS);
    const label = hit ? (this.engine.playback.frame?.labelOf(hit.point) ?? 0) : 0;
    if (label === 0 || label === DELETED) return;
    actions.labels.selectLabel(label);
    actions.tools.setTool('paint');
    this.pulse(0.5, 30);
  }
}
