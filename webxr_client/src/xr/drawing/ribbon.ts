/** Lines in the room, as wide in the picture as they are to be: WebGL's own are one pixel wide. */
import { free } from '../../common/free';
import {
  Color,
  DoubleSide,
  DynamicDrawUsage,
  Float32BufferAttribute,
  GLSL3,
  InstancedBufferGeometry,
  InstancedInterleavedBuffer,
  InterleavedBufferAttribute,
  Mesh,
  RawShaderMaterial,
  type Camera,
  type Vector4,
} from 'three';

/** Width in pixels of the picture. */
export const WIDTH = 2.5;

const VERTEX = /* glsl */ `
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
/** Pixels of the picture from bottom to top. */
uniform float height;
/** End of the piece, 0 or 1, and side of it, −1 or 1. */
in vec3 position;
in vec3 start;
in vec3 end;
const float CLOSEST = -0.01;
void main() {
  vec3 a = (modelViewMatrix * vec4(start, 1.0)).xyz;
  vec3 b = (modelViewMatrix * vec4(end, 1.0)).xyz;
  // Points behind the eyes have no place in the picture: the piece begins before them.
  if (a.z > CLOSEST && b.z < CLOSEST) a = mix(a, b, (CLOSEST - a.z) / (b.z - a.z));
  else if (b.z > CLOSEST && a.z < CLOSEST) b = mix(b, a, (CLOSEST - b.z) / (a.z - b.z));
  vec4 from = projectionMatrix * vec4(a, 1.0);
  vec4 to = projectionMatrix * vec4(b, 1.0);
  // Pixels are square: the projection tells how much wider than high the picture is.
  vec2 square = vec2(projectionMatrix[1][1] / projectionMatrix[0][0], 1.0);
  vec2 along = (to.xy / to.w - from.xy / from.w) * square;
  vec2 across = vec2(-along.y, along.x) / max(length(along), 1e-6) / square;
  gl_Position = position.x < 0.5 ? from : to;
  gl_Position.xy += position.y * across * ${WIDTH.toFixed(1)} / height * gl_Position.w;
}`;

const FRAGMENT = /* glsl */ `
precision mediump float;
uniform vec4 color;
out vec4 result;
void main() { result = color; }`;

export interface RibbonLook {
  readonly color?: string | number;
  /** 0 to 1. */
  readonly opacity?: number;
  readonly order: number;
  /** Nearer things hide it. */
  readonly depth?: boolean;
}

/** A line through places of the scene, drawn over everything before it. */
export class Ribbon {
  readonly mesh: Mesh<InstancedBufferGeometry, RawShaderMaterial>;
  private readonly places: Float32Array;
  private readonly buffer: InstancedInterleavedBuffer;
  private readonly scratch = new Color();

  /** For at most so many places. */
  constructor(
    capacity: number,
    { color = 0xffffff, opacity = 1, order, depth = false }: RibbonLook,
  ) {
    this.places = new Float32Array(3 * capacity);
    // Each piece reads a place and the next one from the same numbers.
    this.buffer = new InstancedInterleavedBuffer(this.places, 3, 1);
    this.buffer.setUsage(DynamicDrawUsage);
    const geometry = new InstancedBufferGeometry();
    const corners = [0, -1, 0, 0, 1, 0, 1, -1, 0, 1, 1, 0];
    geometry.setAttribute('position', new Float32BufferAttribute(corners, 3));
    geometry.setIndex([0, 2, 1, 1, 2, 3]);
    geometry.setAttribute('start', new InterleavedBufferAttribute(this.buffer, 3, 0));
    geometry.setAttribute('end', new InterleavedBufferAttribute(this.buffer, 3, 3));
    geometry.instanceCount = 0;
    const material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { height: { value: 1 }, color: { value: [1, 1, 1, opacity] } },
      transparent: true,
      side: DoubleSide,
      depthTest: depth,
      depthWrite: false,
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = this.mesh.visible = false;
    this.mesh.renderOrder = order;
    this.mesh.onBeforeRender = (_renderer, _scene, camera: Camera & { viewport?: Vector4 }) => {
      if (camera.viewport) material.uniforms['height']!.value = camera.viewport.w;
    };
    this.paint(color);
  }

  /** Give it another colour. */
  paint(color: string | number): void {
    const { r, g, b } = this.scratch.set(color).convertLinearToSRGB();
    const now = this.mesh.material.uniforms['color']!.value as number[];
    now[0] = r;
    now[1] = g;
    now[2] = b;
  }

  set opacity(share: number) {
    (this.mesh.material.uniforms['color']!.value as number[])[3] = share;
  }

  /** Write a place; `show` draws it. */
  put(index: number, x: number, y: number, z: number): void {
    const { places } = this;
    places[3 * index] = x;
    places[3 * index + 1] = y;
    places[3 * index + 2] = z;
  }

  /** Draw through the first `count` places; fewer than two hide it. */
  show(count: number): void {
    this.mesh.visible = count > 1;
    this.mesh.geometry.instanceCount = Math.max(0, count - 1);
    if (count > 1) this.buffer.needsUpdate = true;
  }

  dispose(): void {
    free(this.mesh);
  }
}
