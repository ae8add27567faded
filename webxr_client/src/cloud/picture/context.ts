/** The canvas's graphics context. */

/** Attributes as three.js asks for them: a context that is there already keeps its own. */
const CONTEXT: WebGLContextAttributes = {
  alpha: true,
  depth: true,
  stencil: false,
  antialias: false,
  powerPreference: 'high-performance',
};

/**
 * Make the headset's pictures antialiased while the desk's, which draw points to a texture, are not:
 * three.js creates a session's layer like the canvas's context, which reports antialiasing here.
 */
export function antialiasHeadset(canvas: HTMLCanvasElement): void {
  const gl = canvas.getContext('webgl2', CONTEXT);
  const attributes = gl?.getContextAttributes();
  if (gl && attributes) gl.getContextAttributes = () => ({ ...attributes, antialias: true });
}

/** Whether a program draws in place of a GPU. */
export function isSoftware(gl: WebGLRenderingContext | WebGL2RenderingContext): boolean {
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  return /swiftshader|llvmpipe|software/i.test(name);
}
