/** Projection layers, and sessions without them: some browsers have their API and cannot use it. */

const KEY = 'pointbrush.layers';
const UNUSABLE = 'unusable';

type Presenting = { setSession(session: XRSession): Promise<void> };

/** Whether layers are asked for: they were never found to be unusable in this browser. */
export function layersWanted(): boolean {
  try {
    return localStorage.getItem(KEY) !== UNUSABLE;
  } catch {
    return true;
  }
}

/** Let three.js present a session; where that fails with layers, once more without them. */
export async function present(xr: Presenting, session: XRSession): Promise<void> {
  if (!layersWanted()) dropLayers();
  try {
    await xr.setSession(session);
  } catch (error) {
    if (!dropLayers()) throw error;
    await xr.setSession(session);
    try {
      localStorage.setItem(KEY, UNUSABLE);
    } catch {
      // A browser that keeps nothing finds out again.
    }
  }
}

/** Hide the layers API from three.js, which uses it wherever it is; false where there is none. */
function dropLayers(): boolean {
  const { XRWebGLBinding: Binding } = globalThis as { XRWebGLBinding?: { prototype: object } };
  return (
    Binding !== undefined &&
    'createProjectionLayer' in Binding.prototype &&
    Reflect.deleteProperty(Binding.prototype, 'createProjectionLayer')
  );
}
