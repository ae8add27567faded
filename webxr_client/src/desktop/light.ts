/** The brush under the cursor: its ring, and the points that it lights up. */
import { Color, Vector3 } from 'three';
import { layers } from '../accumulation';
import { pointAt, pointAway } from '../cameras/state';
import { clipMatrix } from '../clip';
import { clipIn, placeIn } from '../cloud/layer';
import { inCapsule, type Hit } from '../cloud/pick';
import type { Viewer } from '../cloud/viewer';
import { FLOOR_SPOT } from '../engine/floor';
import { peek } from '../peek';
import { isStroke, sparesLabels, state } from '../state';
import { brushColor } from '../tools/brush';
import { deskWay } from '../tools/ways';
import type { Aim } from './aim';
import { BrushRing } from './cursor';

export class BrushLight {
  /** Place of the brush on the surface, room coordinates; null off the recording. */
  at: Vector3 | null = null;
  private readonly ring = new BrushRing();
  private readonly color = new Color();
  private readonly place = new Vector3();
  private readonly way = new Vector3();

  constructor(
    private readonly viewer: Viewer,
    private readonly aim: Aim,
  ) {
    viewer.scene.add(this.ring.object);
  }

  /** Show the brush where the cursor is now. */
  update(): void {
    const tool = peek(state.tool);
    const { radius } = peek(state.brush);
    const painting = isStroke(tool);
    const hit = this.aim.hit(painting ? radius : 0.03);
    const frame = this.aim.frame();
    if (!hit || !frame) {
      this.hide();
      return;
    }
    let points = 0;
    if (tool === 'floor') this.show(hit, FLOOR_SPOT);
    else if (painting && deskWay().size !== null) {
      this.show(hit, radius);
      const clip = peek(clipMatrix);
      inCapsule(frame, hit.position, hit.position, radius, () => (points += 1), clip);
      for (const layer of peek(layers)) {
        const at = placeIn(layer, hit.position);
        const count = (point: number): void => {
          if (layer.holds(layer.frame.labelOf(point))) points += 1;
        };
        inCapsule(layer.frame, at, at, radius, count, clipIn(layer, clip));
      }
    } else this.putOut();
    pointAt(hit.position, 'cloud');
    state.hover.value = { label: hit.frame.labelOf(hit.point), distance: hit.distance, points };
  }

  private show(hit: Hit, radius: number): void {
    const { uniforms, camera } = this.viewer;
    const { onlyUnlabeled, through } = peek(state.brush);
    this.color.set(brushColor());
    this.at = this.aim.roomPosition(hit);
    this.ring.show(this.at, radius, this.color, camera, this.aim.pixelAt(hit.distance));
    // As the points' shader mixes colours: with gamma.
    uniforms.setBrushColour(this.color.convertLinearToSRGB());
    uniforms.setOnlyUnlabeled(sparesLabels(peek(state.tool)) && onlyUnlabeled);
    if (through && deskWay().through && peek(state.tool) !== 'floor') {
      const { origin, direction } = this.aim.ray();
      uniforms.lightRay(this.place.fromArray(origin), this.way.fromArray(direction), radius);
    } else uniforms.lightBall(this.place.fromArray(hit.position), radius);
  }

  private putOut(): void {
    this.ring.hide();
    this.at = null;
    this.viewer.uniforms.lightNothing();
  }

  private hide(): void {
    this.putOut();
    pointAway('cloud');
    if (peek(state.hover)) state.hover.value = null;
  }

  dispose(): void {
    this.ring.object.removeFromParent();
  }
}
