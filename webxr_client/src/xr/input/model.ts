/** Simple bodies for controllers and hands: own geometry, nothing is fetched. */
import { type BufferGeometry, CapsuleGeometry, CylinderGeometry, Mesh, MeshBasicMaterial, Vector3, type Object3D } from 'three'; // prettier-ignore
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { Spots } from './kind';
import { Ribbon } from '../drawing/ribbon';
import { tint } from '../drawing/tint';

const BODY = 0x2b3440;
const LIGHT = 0x8b98a8;
/** Render order of hands and controllers: before the panels, which hide objects behind them. */
export const ORDER = 110;

/** Places of the controls of the drawn model. */
export function drawnSpots(): Spots {
  return {
    trigger: new Vector3(0, -0.018, -0.058),
    squeeze: new Vector3(0.014, 0, 0.015),
    pad: new Vector3(0, 0.021, -0.045),
    primary: new Vector3(0.012, 0.014, -0.014),
    secondary: new Vector3(-0.01, 0.014, -0.008),
    up: new Vector3(0, 1, 0),
  };
}

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
 * A handle along the grip's axis (−z points ahead), a head with its pad, a trigger: one mesh, since
 * each one costs its time in every picture.
 */
export function controllerModel(): Mesh {
  const parts = [
    part(new CapsuleGeometry(0.014, 0.085, 6, 16), BODY, 0, 0, 0.015, Math.PI / 2),
    part(new CylinderGeometry(0.025, 0.021, 0.022, 28), BODY, 0, 0.006, -0.045),
    part(new CapsuleGeometry(0.006, 0.014, 4, 10), LIGHT, 0, -0.014, -0.052),
    part(new CylinderGeometry(0.019, 0.019, 0.004, 28), LIGHT, 0, 0.018, -0.045),
    part(new CylinderGeometry(0.0045, 0.0045, 0.004, 12), LIGHT, 0.012, 0.012, -0.014),
    part(new CylinderGeometry(0.0045, 0.0045, 0.004, 12), LIGHT, -0.01, 0.012, -0.008),
  ];
  const geometry = mergeGeometries(parts);
  for (const one of parts) one.dispose();
  // Among the transparent things, so that it is drawn over the panels.
  const look = { vertexColors: true, transparent: true };
  const mesh = new Mesh(geometry, new MeshBasicMaterial(look));
  mesh.renderOrder = ORDER;
  mesh.frustumCulled = false;
  return mesh;
}

/** The pointing ray: a line from the hand to its target. */
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

/** Free the GPU memory of a model. */
export function disposeModel(model: Object3D): void {
  model.removeFromParent();
  model.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    (object.geometry as BufferGeometry).dispose();
    const material = object.material as MeshBasicMaterial;
    material.map?.dispose();
    material.dispose();
  });
}
