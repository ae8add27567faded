/** Place of the question about a doubt: beside the object, with a line to it. */
import { Vector3 } from 'three';
import type { Engine } from '../../engine/engine';
import { halted, unsure } from '../../engine/review';
import { at, MIDDLE, Summaries } from '../../overlays/summary';
import { state } from '../../store/state';
import { peek } from '../../store/watch';
import { Ribbon } from '../drawing/ribbon';
import { INK } from '../drawing/ui';
import type { Rig } from '../moving/rig';
import type { Panel } from './panel';
import type { Placement } from './placement';

export class QuestionPlace {
  private readonly summaries = new Summaries();
  private readonly line = new Ribbon(2, { color: INK.warn, order: 97 });
  /** Middle of the object, and the panel's edge that is nearest to it, in the headset's own space. */
  private readonly object = new Vector3();
  private readonly edge = new Vector3();
  /** The panel hangs beside the object of this question. */
  private beside = false;

  constructor(
    private readonly engine: Engine,
    private readonly rig: Rig,
    private readonly placement: Placement,
  ) {
    rig.group.add(this.line.mesh);
  }

  /** Another question: it is laid anew once the object is loaded. */
  begin(): void {
    this.beside = false;
  }

  /** Once per picture: lay the panel once, and let the line follow the object. */
  update(panel: Panel, now: number): void {
    const { mesh, size } = panel;
    if (!mesh.visible || !this.findObject(now)) {
      this.line.show(0);
      return;
    }
    const { line, object, edge } = this;
    if (!this.beside) this.lay(panel);
    this.beside = true;
    const right = edge.setFromMatrixColumn(mesh.matrix, 0);
    const { elements: m } = mesh.matrix;
    const side = right.x * (object.x - m[12]) + right.z * (object.z - m[14]) > 0 ? 0.5 : -0.5;
    edge.set(side * size.width, 0, 0).applyMatrix4(mesh.matrix);
    line.put(0, edge.x, edge.y, edge.z);
    line.put(1, object.x, object.y, object.z);
    line.show(2);
  }

  /** Beside the object; beside a whole model, which would be hidden otherwise. */
  private lay(panel: Panel): void {
    const { placement, rig, object } = this;
    const { world } = this.engine.viewer;
    const info = peek(state.sequence);
    if (world.scale.x >= 1 || !info) {
      placement.layBeside(panel, object);
      return;
    }
    const [low, high] = this.engine.viewer.bounds(info);
    const middle = low.clone().add(high).multiplyScalar(0.5);
    const radius = (world.scale.x * Math.hypot(high.x - low.x, high.z - low.z)) / 2;
    placement.layBeside(panel, rig.group.worldToLocal(world.localToWorld(middle)), radius);
  }

  private findObject(now: number): boolean {
    const { playback, viewer } = this.engine;
    const label = peek(unsure)[0] ?? peek(halted)?.labels[0];
    if (!playback.frame || label === undefined) return false;
    const summary = this.summaries.of(playback.frame, viewer.room.matrix, now);
    const slot = summary.of(label);
    if (slot < 0) return false;
    this.object.fromArray(summary.values, at(slot, MIDDLE));
    this.rig.group.worldToLocal(viewer.world.localToWorld(this.object));
    return true;
  }

  dispose(): void {
    this.line.dispose();
  }
}
