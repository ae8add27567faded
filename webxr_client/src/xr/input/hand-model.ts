/**
 * A bare hand: a ball at each of its 25 joints and a tapered tube along each bone, skinned by the
 * graphics processor from the joints' places and radii, in one draw call.  Nothing is fetched.
 */
import { BufferGeometry, DoubleSide, Float32BufferAttribute, GLSL3, Mesh, RawShaderMaterial, type Object3D, type Vector3 } from 'three'; // prettier-ignore
import type { Model } from './kind';
import { disposeModel, ORDER } from './model';

const JOINTS = 25;
/** Positions of the finger tips among the joints. */
const THUMB = 4;
const INDEX = 9;
/** Metres, where a browser does not know a joint's radius. */
const RADIUS = 0.008;
/** Corners round a tube, and rings of a ball from pole to pole. */
const ROUND = 10;
const RINGS = 6;

/** First joint of each finger, in the order of the WebXR specification; the wrist is joint 0. */
const THUMB_FIRST = 1;
const FINGERS = [5, 10, 15, 20] as const;
const FINGER_JOINTS = 5;

/** Return the pairs of joints that skin spans: along fingers, and across the palm. */
export function bonesOf(): readonly (readonly [number, number])[] {
  const bones: [number, number][] = [[0, THUMB_FIRST]];
  for (let k = THUMB_FIRST; k < THUMB; k++) bones.push([k, k + 1]);
  FINGERS.forEach((first, i) => {
    bones.push([0, first]);
    for (let k = first; k < first + FINGER_JOINTS - 1; k++) bones.push([k, k + 1]);
    const next = FINGERS[i + 1];
    // From knuckle to knuckle, and the same at the fingers' roots and between the two.
    if (next !== undefined) bones.push([first, next], [first + 1, next + 1], [first, next + 1]);
  });
  bones.push([THUMB_FIRST + 1, FINGERS[0]], [THUMB_FIRST + 1, FINGERS[0] + 1]);
  return bones;
}

const VERTEX = /* glsl */ `
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
/** Place and radius of each joint. */
uniform vec4 joints[${JOINTS}];
/** The bone's two joints (a ball: the same twice), and how far along it. */
in vec3 bone;
/** A place on a ball, or round a tube: its first two numbers. */
in vec3 position;
out vec3 normalInView;
void main() {
  vec4 a = joints[int(bone.x)];
  vec4 b = joints[int(bone.y)];
  vec3 normal = position;
  if (bone.x != bone.y) {
    vec3 along = normalize(b.xyz - a.xyz + vec3(1e-6, 0.0, 0.0));
    vec3 side = normalize(cross(along, abs(along.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
    normal = position.x * side + position.y * cross(side, along);
  }
  vec4 middle = mix(a, b, bone.z);
  normalInView = mat3(modelViewMatrix) * normal;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(middle.xyz + middle.w * normal, 1.0);
}`;

const FRAGMENT = /* glsl */ `
precision mediump float;
in vec3 normalInView;
out vec4 result;
void main() {
  vec3 normal = normalize(normalInView);
  float light = 0.45 + 0.35 * normal.z + 0.2 * normal.y;
  result = vec4(vec3(0.62, 0.68, 0.75) * light, 1.0);
}`;

/** Corners of all balls and tubes; joints are numbers in an attribute. */
function handGeometry(): BufferGeometry {
  const positions: number[] = [];
  const bones: number[] = [];
  const index: number[] = [];
  /** A strip of rings; `place` gives a corner on a ring and how far along the bone that ring is. */
  const rings = (
    count: number,
    joints: readonly [number, number],
    place: (ring: number, angle: number) => readonly [number, number, number, number],
  ): void => {
    const first = positions.length / 3;
    for (let ring = 0; ring < count; ring++) {
      for (let k = 0; k <= ROUND; k++) {
        const [x, y, z, along] = place(ring, (2 * Math.PI * k) / ROUND);
        positions.push(x, y, z);
        bones.push(...joints, along);
        if (ring === 0 || k === 0) continue;
        const at = first + ring * (ROUND + 1) + k;
        const below = at - ROUND - 1;
        index.push(below - 1, below, at, below - 1, at, at - 1);
      }
    }
  };
  for (let joint = 0; joint < JOINTS; joint++) {
    rings(RINGS + 1, [joint, joint], (ring, angle) => {
      const tilt = (Math.PI * ring) / RINGS;
      const level = Math.sin(tilt);
      return [level * Math.cos(angle), Math.cos(tilt), level * Math.sin(angle), 0];
    });
  }
  for (const bone of bonesOf()) {
    rings(2, bone, (ring, angle) => [Math.cos(angle), Math.sin(angle), 0, ring]);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(positions, 3));
  geometry.setAttribute('bone', new Float32BufferAttribute(bones, 3));
  geometry.setIndex(index);
  return geometry;
}

export class HandModel implements Model {
  readonly gripped = false;
  readonly mesh: Mesh<BufferGeometry, RawShaderMaterial>;
  private readonly matrices = new Float32Array(16 * JOINTS);
  private readonly radii = new Float32Array(JOINTS);
  /** Place and radius of each joint, as the shader reads them. */
  private readonly joints = new Float32Array(4 * JOINTS);
  private readonly spaces: XRJointSpace[] = [];

  constructor(hand: XRHand) {
    for (const space of hand.values()) this.spaces.push(space);
    const skin = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { joints: { value: this.joints } },
      transparent: true,
      side: DoubleSide,
    });
    this.mesh = new Mesh(handGeometry(), skin);
    this.mesh.frustumCulled = this.mesh.visible = false;
    this.mesh.renderOrder = ORDER;
  }

  update(frame: XRFrame, space: XRReferenceSpace): void {
    const seen =
      frame.fillPoses?.(this.spaces, space, this.matrices) &&
      frame.fillJointRadii?.(this.spaces, this.radii);
    this.mesh.visible = Boolean(seen);
    if (!seen) return;
    const { joints, matrices, radii } = this;
    for (let i = 0; i < JOINTS; i++) {
      joints[4 * i] = matrices[16 * i + 12]!;
      joints[4 * i + 1] = matrices[16 * i + 13]!;
      joints[4 * i + 2] = matrices[16 * i + 14]!;
      joints[4 * i + 3] = radii[i]! > 0 ? radii[i]! : RADIUS;
    }
  }

  /** The place between the tips of thumb and index finger, in the headset's space. */
  pinch(out: Vector3): boolean {
    const { joints: j } = this;
    const a = 4 * THUMB;
    const b = 4 * INDEX;
    out.set((j[a]! + j[b]!) / 2, (j[a + 1]! + j[b + 1]!) / 2, (j[a + 2]! + j[b + 2]!) / 2);
    return this.mesh.visible;
  }

  /** The tip of the index finger, in the headset's space. */
  fingertip(out: Vector3): boolean {
    const { joints: j } = this;
    out.set(j[4 * INDEX]!, j[4 * INDEX + 1]!, j[4 * INDEX + 2]);
    return this.mesh.visible;
  }

  get object(): Object3D {
    return this.mesh;
  }

  dispose(): void {
    disposeModel(this.mesh);
  }
}
