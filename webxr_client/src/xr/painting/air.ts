/** Shapes drawn in the air: a lasso, or a box by its corners or between both hands. */
import { Matrix4, PerspectiveCamera, Quaternion, Vector3 } from 'three';
import type { Viewer } from '../../cloud/picture/viewer';
import type { Brush, SequenceInfo } from '../../protocol/messages';
import type { Way } from '../../tools/ways';
import type { Place } from './place';
import type { Pointer } from '../input/pointer';
import { Ribbon } from '../drawing/ribbon';
import { within } from '../drawing/vectors';

const CORNERS = 4000;
const SMALLEST = 0.005;
/** Twelve edges as one line; bits choose between the corners' x, y and z. */
const BOX_PATH = [0, 1, 3, 2, 0, 4, 5, 1, 5, 7, 3, 7, 6, 2, 6, 4] as const;

export class AirShape {
  readonly line = new Ribbon(CORNERS, { order: 96 });
  private boxes = false;
  private readonly lasso = new AirLasso();
  private readonly start = new Vector3();
  private readonly from = new Vector3();
  private readonly to = new Vector3();

  constructor(
    private readonly viewer: Viewer,
    private readonly place: Place,
  ) {}

  begin(way: Way, tip: Vector3): void {
    this.boxes = way.name === 'box';
    this.lasso.begin();
    this.start.copy(tip);
    this.from.copy(tip);
    this.to.copy(tip);
  }

  extend(tip: Vector3, other: Pointer | null): void {
    if (this.boxes) this.stretch(tip, other);
    else if (this.lasso.add(tip)) this.drawLast(tip);
  }

  /** Between both hands while the other trigger is held too; else from where one began. */
  private stretch(tip: Vector3, other: Pointer | null): void {
    const two = other?.tracked === true && other.trigger >= 0.5;
    this.from.copy(two ? other.origin : this.start);
    if (two) this.from.addScaledVector(other.direction, other.tip[0]!);
    this.to.copy(tip);
    this.drawBox();
  }

  hide(): void {
    this.line.show(0);
  }

  /** Fields of a stroke of this shape besides its brush; null when it encloses nothing. */
  end(eye: Vector3, info: SequenceInfo): Partial<Brush> | null {
    if (!this.boxes) return this.lasso.end(eye, this.place.localFromScene, info);
    return this.box(info);
  }

  /** The box lies along the room's axes. */
  private box(info: SequenceInfo): Partial<Brush> {
    const { world, room } = this.viewer;
    const one = world.worldToLocal(this.from.clone());
    const other = world.worldToLocal(this.to.clone());
    const size = other.clone().sub(one);
    const localFromRoom = new Matrix4().copy(room.matrix).invert();
    const { x, y, z } = one.add(other).multiplyScalar(0.5).applyMatrix4(localFromRoom);
    const edge = (length: number): number => Math.max(SMALLEST, Math.abs(length));
    return {
      center: [x + info.shift[0], y + info.shift[1], z + info.shift[2]],
      size: [edge(size.x), edge(size.y), edge(size.z)],
      quaternion: new Quaternion().setFromRotationMatrix(localFromRoom).toArray(),
    };
  }

  private drawLast(tip: Vector3): void {
    const end = this.lasso.corners.length / 3 - 1;
    if (end >= CORNERS) return;
    this.line.put(end, tip.x, tip.y, tip.z);
    this.line.show(end + 1);
  }

  private drawBox(): void {
    const { from, line, to } = this;
    for (let i = 0; i < BOX_PATH.length; i++) {
      const bits = BOX_PATH[i]!;
      line.put(i, bits & 1 ? to.x : from.x, bits & 2 ? to.y : from.y, bits & 4 ? to.z : from.z);
    }
    line.show(BOX_PATH.length);
  }

  dispose(): void {
    this.line.dispose();
  }
}

/** An outline drawn in the air: a volume seen from the head, as a polygon and a camera. */
const STEP = 0.008;
const MOST = 4000;
/** Wide enough for any outline that arms can draw in front of the eyes. */
const FOV = 120;

export class AirLasso {
  /** x, y, z of each corner, in the scene. */
  readonly corners: number[] = [];
  private readonly camera = new PerspectiveCamera(FOV, 1, 0.05, 1000);
  private readonly at = new Vector3();

  begin(): void {
    this.corners.length = 0;
  }

  /** True when a corner was added. */
  add(place: Vector3): boolean {
    const { corners } = this;
    const end = corners.length;
    if (end >= 3) {
      this.at.fromArray(corners, end - 3);
      if (within(this.at, place, STEP) || end >= 3 * MOST) return false;
    }
    corners.push(place.x, place.y, place.z);
    return true;
  }

  /** Polygon and `clip_from_source`, seen from `eye`; null when nothing is enclosed. */
  end(
    eye: Vector3,
    localFromScene: Matrix4,
    info: SequenceInfo,
  ): { polygon: [number, number][]; matrix: number[] } | null {
    const count = this.corners.length / 3;
    if (count < 3) return null;
    const { camera, at } = this;
    const middle = new Vector3();
    for (let i = 0; i < count; i++) middle.add(at.fromArray(this.corners, 3 * i));
    camera.position.copy(eye);
    camera.lookAt(middle.divideScalar(count));
    camera.updateMatrixWorld(true);
    const polygon: [number, number][] = [];
    for (let i = 0; i < count; i++) {
      at.fromArray(this.corners, 3 * i).project(camera);
      polygon.push([clamp(at.x), clamp(at.y)]);
    }
    const [x, y, z] = info.shift;
    const matrix = new Matrix4()
      .multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse)
      .multiply(localFromScene.clone().invert())
      .multiply(new Matrix4().makeTranslation(-x, -y, -z))
      .transpose()
      .toArray();
    return { polygon, matrix };
  }
}

function clamp(value: number): number {
  return Math.min(1, Math.max(-1, value));
}
