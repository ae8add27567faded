/** Projection layers, and sessions without them: some browsers have their API and cannot use it. */
import { keep, kept } from '../store/kept';

const KEY = 'pointbrush.layers';
const UNUSABLE = 'unusable';

type Presenting = { setSession(session: XRSession): Promise<void> };

/** Whether layers are asked for: they were never found to be unusable in this browser. */
export function layersWanted(): boolean {
  return kept(KEY) !== UNUSABLE;
}

/** Let three.js present a session; where that fails with layers, once more without them. */
export async function present(xr: Presenting, session: XRSession): Promise<void> {
  if (!layersWanted()) dropLayers();
  try {
    await xr.setSession(session);
  } catch (error) {
    if (!dropLayers()) throw error;
    await xr.setSession(session);
    keep(KEY, UNUSABLE);
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
