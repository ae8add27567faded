/**
 * Depth in the headset: hands are centimetres from the eyes while a street goes on for hundreds of
 * metres.  The near plane is close for recordings of any size, and depth is reversed if the browser
 * has EXT_clip_control (1 at the near plane, 0 at the far one): floating point is finest near 0, so
 * that distant surfaces keep their order.  Other browsers use the usual depth.
 */
import type { Camera, Matrix4, PerspectiveCamera, WebGLRenderer } from 'three';

/** Metres from the eyes to the near plane. */
export const NEAR = 0.05;
/** Least distance of the far plane in metres, and its distance in sizes of the recording. */
const LEAST_FAR = 100;
const FAR_SIZES = 6;

/** Metres to the far plane for a recording so large in the scene; in few steps, as one scales it. */
export function farFor(size: number): number {
  return 2 ** Math.ceil(Math.log2(Math.max(LEAST_FAR, FAR_SIZES * size)));
}

/**
 * Turn a projection's depth from −1 … 1 to 1 (near) … 0 (far).  A session that was told of reversed
 * depth has 1 at the near plane already; the first picture's, or that of a browser without it, −1.
 */
export function reverseDepth({ elements }: Matrix4): void {
  const sign = elements[10] > 0 ? 1 : -1;
  for (let column = 0; column < 4; column++) {
    const w = elements[4 * column + 3]!;
    elements[4 * column + 2] = (w + sign * elements[4 * column + 2]!) / 2;
  }
}

/** Whether the browser can draw with reversed depth. */
export function canReverse(renderer: WebGLRenderer): boolean {
  return renderer.extensions.has('EXT_clip_control');
}

/** The next pictures are drawn with reversed depth, or with the usual one. */
export function setReversed(renderer: WebGLRenderer, on: boolean): void {
  renderer.state.buffers.depth.setReversed(on);
}

/**
 * Bring the planes to a headset's camera, which three.js tells the session.  Reversed depth is told by
 * a `depthNear` beyond `depthFar` (WebXR: `XRRenderState`), so that the compositor reads it rightly.
 */
export function setPlanes(camera: PerspectiveCamera, size: number, reversed: boolean): void {
  const far = farFor(size);
  camera.near = reversed ? far : NEAR;
  camera.far = reversed ? NEAR : far;
}

const marked = new WeakSet<Camera>();

/**
 * Reverse the projections that the session gave for this picture.  three.js 0.187 reverses only
 * projections that it makes itself, and would replace a session's by one of its own.
 */
export function reverseEyes(eyes: readonly PerspectiveCamera[]): void {
  for (let i = 0; i < eyes.length; i++) {
    const eye = eyes[i]!;
    if (!marked.has(eye)) {
      marked.add(eye);
      Object.defineProperty(eye, 'reversedDepth', { value: true });
    }
    reverseDepth(eye.projectionMatrix);
    eye.projectionMatrixInverse.copy(eye.projectionMatrix).invert();
  }
}
