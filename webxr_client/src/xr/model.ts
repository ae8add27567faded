/** Simple bodies for controllers and hands: own geometry, nothing is fetched. */
import { BufferGeometry, CapsuleGeometry, CylinderGeometry, Float32BufferAttribute, Line, LineBasicMaterial, Mesh, MeshBasicMaterial, TorusGeometry, type Object3D, type Vector3 } from 'three'; // prettier-ignore
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { Device } from './devices';
import { tint } from './tint';

const BODY = 0x2b3440;
const LIGHT = 0x8b98a8;
/** Hands and controllers are drawn behind the panels, which hide what is behind them. */
export const ORDER = 110;

/** A part of one colour, moved and turned about x. */
function part(
  geometry: BufferGeometry,
  color: number,
  x: number,
  y: number,
  z: number,
  turn = 0,
): BufferGeometry {
  return tint(geometry, color).rotateX(turn).translate(x, y, z);
}

/**
 * A handle along the grip's axis (−z points ahead), a head with its pad or stick, a trigger: one mesh,
 * since each one costs its time in every picture.
 */
export function controllerModel(device: Device): Mesh {
  const parts = [
    part(new CapsuleGeometry(0.014, 0.085, 6, 16), BODY, 0, 0, 0.015, Math.PI / 2),
    part(new CylinderGeometry(0.025, 0.021, 0.022, 28), BODY, 0, 0.006, -0.045),
    part(new CapsuleGeometry(0.006, 0.014, 4, 10), LIGHT, 0, -0.014, -0.052),
  ];
  if (device.pad === 'touchpad') {
    const lean = Math.PI / 2 - 0.5;
    parts.push(
      part(new CylinderGeometry(0.019, 0.019, 0.004, 28), LIGHT, 0, 0.018, -0.045),
      part(new TorusGeometry(0.042, 0.008, 8, 32), BODY, 0, -0.002, -0.1, lean),
    );
  } else {
    parts.push(
      part(new CylinderGeometry(0.008, 0.007, 0.016, 16), LIGHT, 0, 0.025, -0.05),
      part(new CylinderGeometry(0.0045, 0.0045, 0.004, 12), LIGHT, 0.008, 0.018, -0.034),
      part(new CylinderGeometry(0.0045, 0.0045, 0.004, 12), LIGHT, -0.006, 0.018, -0.028),
    );
  }
  const geometry = mergeGeometries(parts);
  for (const one of parts) one.dispose();
  // Among the transparent things, so that it is drawn over the panels.
  const look = { vertexColors: true, transparent: true };
  const mesh = new Mesh(geometry, new MeshBasicMaterial(look));
  mesh.renderOrder = ORDER;
  mesh.frustumCulled = false;
  return mesh;
}

/** The pointing ray: a line from the hand to what it is on. */
export class Ray {
  /** Metres that it reaches. */
  readonly length = new Float64Array(1);
  readonly line: Line<BufferGeometry, LineBasicMaterial>;

  constructor() {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new Float32BufferAttribute(new Float32Array(6), 3));
    const material = new LineBasicMaterial({
      color: 0xffffff,
      transparent: true,
      opacity: 0.75,
      depthTest: false,
    });
    this.line = new Line(geometry, material);
    this.line.frustumCulled = false;
    this.line.renderOrder = 120;
    this.line.visible = false;
  }

  /** Lie along a hand's ray; no length hides it. */
  show(origin: Vector3, direction: Vector3): void {
    const length = this.length[0]!;
    this.line.visible = length > 0;
    if (length <= 0) return;
    const ends = this.line.geometry.getAttribute('position');
    const { array } = ends;
    array[0] = origin.x;
    array[1] = origin.y;
    array[2] = origin.z;
    array[3] = origin.x + direction.x * length;
    array[4] = origin.y + direction.y * length;
    array[5] = origin.z + direction.z * length;
    ends.needsUpdate = true;
  }

  dispose(): void {
    this.line.removeFromParent();
    this.line.geometry.dispose();
    this.line.material.dispose();
  }
}

/** Free what the GPU holds of a model. */
export function disposeModel(model: Object3D): void {
  model.removeFromParent();
  model.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    (object.geometry as BufferGeometry).dispose();
    (object.material as MeshBasicMaterial).dispose();
  });
}
