/** Simple bodies for controllers and hands: own geometry, nothing is fetched. */
import { BufferGeometry, CapsuleGeometry, CylinderGeometry, DynamicDrawUsage, Float32BufferAttribute, InstancedMesh, Line, LineBasicMaterial, Mesh, MeshBasicMaterial, SphereGeometry, TorusGeometry, Matrix4, type Object3D, type Vector3 } from 'three'; // prettier-ignore
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { Device } from './devices';
import type { Model } from './kinds/kind';
import { tint } from './tint';

const BODY = 0x2b3440;
const LIGHT = 0x8b98a8;
const JOINTS = 25;
/** Positions of the finger tips among the joints. */
const THUMB = 4;
const INDEX = 9;
const ORDER = 110;

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

/** A hand as its 25 joints. */
export class HandModel implements Model {
  readonly gripped = false;
  readonly mesh: InstancedMesh;
  private readonly matrices = new Float32Array(16 * JOINTS);
  private readonly radii = new Float32Array(JOINTS);
  private readonly spaces: XRJointSpace[] = [];
  private readonly matrix = new Matrix4();

  constructor(hand: XRHand) {
    for (const space of hand.values()) this.spaces.push(space);
    const material = new MeshBasicMaterial({ color: LIGHT, transparent: true });
    this.mesh = new InstancedMesh(new SphereGeometry(1, 10, 8), material, JOINTS);
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = ORDER;
  }

  update(frame: XRFrame, space: XRReferenceSpace): void {
    const seen =
      frame.fillPoses?.(this.spaces, space, this.matrices) &&
      frame.fillJointRadii?.(this.spaces, this.radii);
    this.mesh.visible = Boolean(seen);
    if (!seen) return;
    for (let i = 0; i < this.spaces.length; i++) {
      const radius = this.radii[i]! || 0.008;
      this.matrix.fromArray(this.matrices, 16 * i);
      const e = this.matrix.elements;
      for (let k = 0; k < 12; k++) e[k]! *= radius;
      e[3] = e[7] = e[11] = 0;
      this.mesh.setMatrixAt(i, this.matrix);
    }
    this.mesh.instanceMatrix.needsUpdate = true;
  }

  /** The place between the tips of thumb and index finger, in the headset's space. */
  pinch(out: Vector3): boolean {
    const { matrices: m } = this;
    out.set(
      (m[16 * THUMB + 12]! + m[16 * INDEX + 12]!) / 2,
      (m[16 * THUMB + 13]! + m[16 * INDEX + 13]!) / 2,
      (m[16 * THUMB + 14]! + m[16 * INDEX + 14]!) / 2,
    );
    return this.mesh.visible;
  }

  /** The tip of the index finger, in the headset's space. */
  fingertip(out: Vector3): boolean {
    const { matrices: m } = this;
    out.set(m[16 * INDEX + 12]!, m[16 * INDEX + 13]!, m[16 * INDEX + 14]);
    return this.mesh.visible;
  }

  get object(): Object3D {
    return this.mesh;
  }

  dispose(): void {
    disposeModel(this.mesh);
    this.mesh.dispose();
  }
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
