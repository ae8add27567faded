/** Simple bodies for controllers and hands: own geometry, nothing is fetched. */
import { type BufferGeometry, CapsuleGeometry, CylinderGeometry, Mesh, MeshBasicMaterial, TorusGeometry, type Object3D, type Vector3 } from 'three'; // prettier-ignore
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { Device } from './devices';
import { Ribbon } from '../drawing/ribbon';
import { tint } from '../drawing/tint';

const BODY = 0x2b3440;
const LIGHT = 0x8b98a8;
/** Hands and controllers are drawn behind the panels, which hide what is behind them. */
export const ORDER = 110;
/** Over the pad or stick, metres in the grip's space. */
export const PAD = { x: 0, y: 0.042, z: -0.05 } as const;

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
  readonly line = new Ribbon(2, { opacity: 0.75, order: 120 });

  /** Lie along a hand's ray; no length hides it. */
  show(origin: Vector3, direction: Vector3): void {
    const { line } = this;
    const length = this.length[0]!;
    line.put(0, origin.x, origin.y, origin.z);
    line.put(
      1,
      origin.x + direction.x * length,
      origin.y + direction.y * length,
      origin.z + direction.z * length,
    );
    line.show(length > 0 ? 2 : 0);
  }

  dispose(): void {
    this.line.dispose();
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
