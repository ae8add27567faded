/** Eye-dome lighting: points go to a texture first, and come to the screen with their edges shaded. */
import { BufferAttribute, BufferGeometry, DepthTexture, GLSL3, Mesh, NearestFilter, RawShaderMaterial, UnsignedIntType, Vector2, Vector3, WebGLRenderTarget } from 'three'; // prettier-ignore
import type { Lens } from './lens';
import { EYE_DOME_FRAGMENT, SCREEN_VERTEX } from './shaders';

/** Of the shading of edges in depth. */
const SHADING = 4;
/** Pixels between a place and those that tell whether it is at an edge. */
const EDGE = 1.5;

export class EyeDome {
  readonly target: WebGLRenderTarget;
  /** Fills the screen in the ordinary scene, with the points' depth. */
  readonly quad: Mesh<BufferGeometry, RawShaderMaterial>;

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
        strength: { value: SHADING },
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

  /** Shade edges in depth, and draw the edge of what a click would take. */
  set(shaded: boolean, outlined: boolean): void {
    const { uniforms } = this.quad.material;
    uniforms['strength']!.value = shaded ? SHADING : 0;
    uniforms['outline']!.value = outlined ? EDGE : 0;
  }

  setCamera(camera: Lens): void {
    const { near, far, halfHeight } = camera;
    // As deep as the same picture in perspective, where a depth counts by its ratio.
    const flat = halfHeight && 1 / (Math.LN2 * camera.distanceOf(halfHeight));
    (this.quad.material.uniforms['clip']!.value as Vector3).set(near, far, flat);
  }
}
