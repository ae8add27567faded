/** Eye-dome lighting: points are drawn to a texture, then to the screen with shaded edges. */
import { BufferAttribute, BufferGeometry, DepthTexture, GLSL3, Mesh, NearestFilter, RawShaderMaterial, UnsignedIntType, Vector2, Vector3, WebGLRenderTarget } from 'three'; // prettier-ignore
import type { Lens } from './lens';
import { EYE_DOME_FRAGMENT, SCREEN_VERTEX } from './shaders';

/** Strength of the shading by depth, and the part of its light that the darkest edge keeps. */
type Shading = readonly [strength: number, least: number];
const NO_SHADING: Shading = [0, 1];
/** Shading of edges only, for colours that show shapes. */
const EDGE_SHADING: Shading = [4, 0.67];
/** Of shapes in the colours of classes, which have to stay recognisable. */
const CLASS_SHADING: Shading = [16, 0.5];
/** Of all shapes, which plain points show by nothing else. */
const SHAPE_SHADING: Shading = [60, 0.2];
/** Pixels between a place and the places that are compared with it to find edges. */
const EDGE = 1.5;

export class EyeDome {
  readonly target: WebGLRenderTarget;
  /** Fills the screen in the ordinary scene, with the points' depth. */
  readonly quad: Mesh<BufferGeometry, RawShaderMaterial>;
  private readonly shading = { value: EDGE_SHADING };
  private view = { on: true, plain: false };
  private flat = false;

  constructor() {
    this.target = new WebGLRenderTarget(1, 1, {
      minFilter: NearestFilter,
      magFilter: NearestFilter,
      depthTexture: new DepthTexture(1, 1, UnsignedIntType),
      stencilBuffer: false,
    });
    const triangle = new BufferGeometry();
    const corners = new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]);
    triangle.setAttribute('position', new BufferAttribute(corners, 3));
    const material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: SCREEN_VERTEX,
      fragmentShader: EYE_DOME_FRAGMENT,
      uniforms: {
        points: { value: this.target.texture },
        depths: { value: this.target.depthTexture },
        texel: { value: new Vector2() },
        clip: { value: new Vector3() },
        shading: this.shading,
        outline: { value: 0 },
      },
    });
    this.quad = new Mesh(triangle, material);
    this.quad.frustumCulled = false;
    this.quad.renderOrder = -5;
    this.quad.visible = false;
  }

  setSize(width: number, height: number, pixelRatio: number): void {
    this.target.setSize(width, height);
    const texel = this.quad.material.uniforms['texel']!.value as Vector2;
    texel.set(pixelRatio / width, pixelRatio / height);
  }

  /** Shade by depth or not; `plain`: the points' colours do not show shapes. */
  shade(on: boolean, plain: boolean): void {
    this.view = { on, plain };
    this.choose();
  }

  /** Shade the colours of classes, or by the view alone. */
  setFlat(flat: boolean): void {
    this.flat = flat;
    this.choose();
  }

  private choose(): void {
    const { on, plain } = this.view;
    const shapes = this.flat ? CLASS_SHADING : plain ? SHAPE_SHADING : EDGE_SHADING;
    this.shading.value = on ? shapes : NO_SHADING;
  }

  get shades(): boolean {
    return this.shading.value !== NO_SHADING;
  }

  /** Draw the edge of the points that a click would take, or not. */
  outline(on: boolean): void {
    this.quad.material.uniforms['outline']!.value = on ? EDGE : 0;
  }

  setCamera(camera: Lens): void {
    const { near, far, halfHeight } = camera;
    // As deep as the same picture in perspective, where a depth counts by its ratio.
    const flat = halfHeight && 1 / (Math.LN2 * camera.distanceOf(halfHeight));
    (this.quad.material.uniforms['clip']!.value as Vector3).set(near, far, flat);
  }
}
