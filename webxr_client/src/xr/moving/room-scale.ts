/** Scales that a person chooses for the room: a model, true scale, larger than life; and the way back. */
import type { Vector3 } from 'three';
import { actions } from '../../store/actions';
import type { Viewer } from '../../cloud/picture/viewer';
import { notify, state } from '../../store/state';
import { peek } from '../../store/watch';
import type { Rig } from './rig';
import { placeModel, resetWorld, scaleAbout } from './world';

/** The place of a person in the scene, and the level direction in which they looked. */
interface StandingPlace {
  readonly place: Vector3;
  readonly ahead: Vector3;
}

export class RoomScale {
  /** Before another scale than the true one was chosen. */
  private placeBeforeScale: StandingPlace | null = null;

  constructor(
    private readonly viewer: Viewer,
    private readonly rig: Rig,
    /** Things at hand are elsewhere; `settles`: so is the person. */
    private readonly moved: (settles: boolean) => void,
  ) {}

  to(scale: number): void {
    const { viewer } = this;
    const { world } = viewer;
    const { head, ahead } = this.rig;
    const info = peek(state.sequence);
    const grown = scale / world.scale.x;
    if (world.scale.x === 1) this.placeBeforeScale = { place: head.clone(), ahead: ahead.clone() };
    if (scale < 1 && info) placeModel(world, scale, viewer.bounds(info), head, ahead);
    else scaleAbout(world, scale, head.clone().addScaledVector(ahead, 0.6).setY(0));
    this.moved(false);
    actions.tools.setRadius(peek(state.brush).radius / grown);
  }

  /** 1:1 on the floor; one stands where one stood before the scale was chosen. */
  reset(): void {
    const { world } = this.viewer;
    actions.tools.setRadius(peek(state.brush).radius * world.scale.x);
    resetWorld(world);
    if (this.placeBeforeScale)
      this.rig.standAt(this.placeBeforeScale.place, this.placeBeforeScale.ahead);
    this.placeBeforeScale = null;
    this.moved(true);
    notify(
      'info',
      'Back at true scale',
      'The recording stands on the floor. You are back at your place.',
    );
  }
}
