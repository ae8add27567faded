/** Surroundings of the recording: a quiet sky, a horizon, and a floor with a metre grid. */
import {
  BackSide,
  GLSL3,
  Group,
  Mesh,
  PlaneGeometry,
  RawShaderMaterial,
  SphereGeometry,
} from 'three';

const SKY_VERTEX = /* glsl */ `
precision highp float;
in vec3 position;
uniform mat4 modelViewMatrix, projectionMatrix;
out vec3 direction;
void main() {
  direction = position;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_Position.z = gl_Position.w;
}
`;

const SKY_FRAGMENT = /* glsl */ `
precision highp float;
in vec3 direction;
uniform float light;   // 0 dark, 1 light
out vec4 result;
void main() {
  float up = normalize(direction).y;
  vec3 horizon = mix(vec3(0.165, 0.192, 0.232), vec3(0.93, 0.95, 0.97), light);
  vec3 zenith = mix(vec3(0.052, 0.064, 0.082), vec3(0.74, 0.80, 0.87), light);
  vec3 ground = mix(vec3(0.070, 0.080, 0.096), vec3(0.80, 0.83, 0.86), light);
  vec3 colour = up > 0.0
    ? mix(horizon, zenith, smoothstep(0.0, 0.75, up))
    : mix(horizon * 0.93, ground, smoothstep(0.0, 0.35, -up));
  // A trace of noise, so that the dark gradient shows no bands.
  float noise = fract(sin(dot(gl_FragCoord.xy, vec2(12.9898, 78.233))) * 43758.5453);
  result = vec4(colour + (noise - 0.5) / 255.0, 1.0);
}
`;

const FLOOR_VERTEX = /* glsl */ `
precision highp float;
in vec3 position;
uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
uniform float extent;
out vec2 place;
void main() {
  vec4 world = modelMatrix * vec4(position.x * extent, 0.0, -position.y * extent, 1.0);
  place = vec2(position.x, -position.y) * extent;
  vec4 eye = viewMatrix * world;
  gl_Position = projectionMatrix * eye;
}
`;

const FLOOR_FRAGMENT = /* glsl */ `
precision highp float;
in vec2 place;
uniform float cell, extent, light;
out vec4 result;

float lines(float size, float width) {
  vec2 at = place / size;
  vec2 wide = fwidth(at);
  vec2 near = abs(fract(at - 0.5) - 0.5) / max(wide, vec2(1e-6));
  // Lines closer than a few pixels would shimmer: they fade instead.
  float fade = 1.0 - smoothstep(0.15, 0.5, max(wide.x, wide.y));
  return (1.0 - min(min(near.x, near.y) / width, 1.0)) * fade;
}

void main() {
  float fine = lines(cell, 1.0) * 0.20;
  float coarse = lines(cell * 5.0, 1.3) * 0.34;
  float alpha = max(fine, coarse) * (1.0 - smoothstep(0.25, 1.0, length(place) / extent));
  if (alpha < 0.004) discard;
  result = vec4(mix(vec3(0.62, 0.70, 0.80), vec3(0.25, 0.32, 0.40), light), alpha);
}
`;

export class Backdrop {
  readonly group = new Group();
  private readonly light = { value: 0 };
  private readonly sky: Mesh<SphereGeometry, RawShaderMaterial>;
  private readonly floor: Mesh<PlaneGeometry, RawShaderMaterial>;

  constructor() {
    const sky = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: SKY_VERTEX,
      fragmentShader: SKY_FRAGMENT,
      uniforms: { light: this.light },
      side: BackSide,
      depthTest: false,
      depthWrite: false,
    });
    this.sky = new Mesh(new SphereGeometry(10, 24, 16), sky);
    this.sky.renderOrder = -10;
    this.sky.frustumCulled = false;
    const floor = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: FLOOR_VERTEX,
      fragmentShader: FLOOR_FRAGMENT,
      uniforms: { extent: { value: 20 }, cell: { value: 1 }, light: this.light },
      transparent: true,
      depthWrite: false,
      side: 2,
    });
    this.floor = new Mesh(new PlaneGeometry(2, 2), floor);
    this.floor.frustumCulled = false;
    this.floor.renderOrder = 5;
    this.group.add(this.sky, this.floor);
  }

  /** The sky stays round the eye. */
  follow(eye: { x: number; y: number; z: number }): void {
    this.sky.position.set(eye.x, eye.y, eye.z);
  }

  /** Fit the grid to a recording `size` metres across. */
  fit(size: number): void {
    const cell = size < 3 ? 0.25 : size < 40 ? 1 : 10 ** Math.round(Math.log10(size / 30));
    this.floor.material.uniforms['cell']!.value = cell;
    this.floor.material.uniforms['extent']!.value = Math.max(30 * cell, 1.6 * size);
  }

  /** Light or dark surroundings. */
  setLight(on: boolean): void {
    this.light.value = on ? 1 : 0;
  }

  showFloor(on: boolean): void {
    this.floor.visible = on;
  }

  /** Off where the real room is seen through the headset. */
  showSky(on: boolean): void {
    this.sky.visible = on;
  }
}
