/** The brush under the cursor: its ring, and the points that it lights up. */
import { Color, type Vector3 } from 'three';
import { inCapsule, type Hit } from '../cloud/pick';
import type { Viewer } from '../cloud/viewer';
import { FLOOR_SPOT } from '../engine/floor';
import { activeLabel, isStroke, state } from '../state';
import type { Aim } from './aim';
import { BrushRing } from './cursor';

const TOOL_COLORS = { erase: '#e8edf2', delete: '#ff5d5d', restore: '#7ddc8f' } as const;

export function toolColor(): string {
  const tool = state.tool.peek();
  if (tool === 'paint') return activeLabel.peek()?.color ?? '#ffffff';
  return tool === 'erase' || tool === 'delete' || tool === 'restore'
    ? TOOL_COLORS[tool]
    : '#ffffff';
}

export class BrushLight {
  /** Where the brush is on the surface, room coordinates; null off the recording. */
  at: Vector3 | null = null;
  private readonly ring = new BrushRing();
  private readonly color = new Color();

  constructor(
    private readonly viewer: Viewer,
    private readonly aim: Aim,
  ) {
    viewer.scene.add(this.ring.object);
  }

  /** Show the brush where the cursor is now. */
  update(): void {
    const tool = state.tool.peek();
    const { shape, radius } = state.brush.peek();
    const painting = isStroke(tool);
    const hit = this.aim.hit(painting ? radius : 0.03);
    const frame = this.aim.frame();
    if (!hit || !frame) {
      this.hide();
      return;
    }
    let points = 0;
    if (tool === 'floor') this.show(hit, FLOOR_SPOT);
    else if (painting && shape !== 'lasso') {
      this.show(hit, radius);
      inCapsule(frame, hit.position, hit.position, radius, () => (points += 1));
    } else this.putOut();
    state.hover.value = { label: frame.labelOf(hit.point), distance: hit.distance, points };
  }

  private show(hit: Hit, radius: number): void {
    const { uniforms, camera } = this.viewer;
    const { shape, onlyUnlabeled, through } = state.brush.peek();
    this.color.set(toolColor());
    this.at = this.aim.roomPosition(hit);
    this.ring.show(this.at, radius, this.color, camera, this.aim.pixelAt(hit.distance));
    // As the points' shader mixes colours: with gamma.
    const { r, g, b } = this.color.convertLinearToSRGB();
    uniforms.brushColour.value.set(r, g, b);
    uniforms.brushRadius.value = radius;
    uniforms.brushOnlyUnlabeled.value = state.tool.peek() === 'paint' && onlyUnlabeled ? 1 : 0;
    if (through && shape === 'brush' && state.tool.peek() !== 'floor') {
      const { origin, direction } = this.aim.ray();
      uniforms.brushMode.value = 2;
      uniforms.brushA.value.set(...origin);
      uniforms.brushB.value.set(direction[0], direction[1], direction[2]);
      return;
    }
    uniforms.brushMode.value = 1;
    uniforms.brushA.value.set(...hit.position);
    uniforms.brushB.value.set(...hit.position);
  }

  private putOut(): void {
    this.ring.hide();
    this.at = null;
    this.viewer.uniforms.brushMode.value = 0;
  }

  private hide(): void {
    this.putOut();
    if (state.hover.peek()) state.hover.value = null;
  }

  dispose(): void {
    this.ring.object.removeFromParent();
  }
}
