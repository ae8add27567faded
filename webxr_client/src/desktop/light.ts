/** The brush under the cursor: its ring, and the points that it lights up. */
import {
  Color,
  Group,
  Mesh,
  MeshBasicMaterial,
  type PerspectiveCamera,
  RingGeometry,
  Vector3,
} from 'three';
import { layers } from '../cloud/points/accumulation';
import { pointAt, clearPointed } from '../cameras/state';
import { clipMatrix } from '../tools/clip';
import { clipIn, placeIn } from '../cloud/points/layer';
import { type Hit, inCapsule } from '../cloud/points/pick';
import type { Viewer } from '../cloud/picture/viewer';
import { FLOOR_SPOT } from '../engine/floor';
import { peek } from '../store/watch';
import { isStroke, sparesLabels, state } from '../store/state';
import { brushColor } from '../tools/brush';
import { deskWay } from '../tools/ways';
import type { Aim } from '../view/aim';

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
    clearPointed('cloud');
    if (peek(state.hover)) state.hover.value = null;
  }
}

// prettier-ignore

const CORNERS = 72;
/** Pixels of the line, and of the dark edge on either side of it. */
const LINE = 2;
const EDGE = 1;

/** The brush on the surface: a ring that faces the eye, in the label's colour, edged dark. */
class BrushRing {
  readonly object = new Group();
  private readonly line = ring(new Color(0xffffff), 11, 1);
  private readonly edge = ring(new Color(0x05070a), 10, 0.55);
  private thickness = 0;

  constructor() {
    this.object.add(this.edge, this.line);
    this.object.visible = false;
  }

  /** `pixel`: metres that one pixel covers at the ring's distance. */
  show(at: Vector3, radius: number, color: Color, camera: PerspectiveCamera, pixel: number): void {
    this.object.position.copy(at);
    this.object.quaternion.copy(camera.quaternion);
    this.object.scale.setScalar(radius);
    this.line.material.color.copy(color);
    this.shape(Math.min(0.5, pixel / radius));
    this.object.visible = true;
  }

  hide(): void {
    this.object.visible = false;
  }

  /** Lines as thick on screen at any distance; new geometry only when that changes visibly. */
  private shape(pixel: number): void {
    if (Math.abs(pixel / this.thickness - 1) < 0.1) return;
    this.thickness = pixel;
    this.line.geometry.dispose();
    this.edge.geometry.dispose();
    this.line.geometry = new RingGeometry(1 - LINE * pixel, 1, CORNERS);
    this.edge.geometry = new RingGeometry(1 - (LINE + EDGE) * pixel, 1 + EDGE * pixel, CORNERS);
  }
}

function ring(color: Color, order: number, opacity: number): Mesh<RingGeometry, MeshBasicMaterial> {
  const material = new MeshBasicMaterial({ color, opacity, transparent: true, depthTest: false });
  const mesh = new Mesh(new RingGeometry(0.95, 1, CORNERS), material);
  mesh.renderOrder = order;
  mesh.frustumCulled = false;
  return mesh;
}
