/** Facts of a session as it began: features, reference spaces, the layer that is drawn into. */
import type { Viewer } from '../cloud/picture/viewer';
import type { HeadsetLayer, HeadsetSession, HeadsetSpace } from '../protocol/values';
import { wanted } from '../xr/headset';

const SPACES = ['viewer', 'local', 'local-floor', 'bounded-floor', 'unbounded'] as const;

/** Return the features of a session. */
export async function describe(
  session: XRSession,
  { renderer }: Viewer,
  mode: XRSessionMode,
  floor: boolean,
): Promise<HeadsetSession> {
  const { enabledFeatures } = session;
  const features = (wanted().optionalFeatures ?? []).map((name) => ({
    name,
    granted: enabledFeatures ? enabledFeatures.includes(name) : null,
  }));
  const blend = session.environmentBlendMode;
  const layer = layerOf(session, renderer.xr);
  return { mode, blend, floor, features, spaces: await spacesOf(session), layer };
}

async function spacesOf(session: XRSession): Promise<HeadsetSpace[]> {
  const requests = SPACES.map(async (name) => {
    const space = session.requestReferenceSpace(name);
    return { name, given: await space.then(() => true, () => false) };
  }); // prettier-ignore
  return Promise.all(requests);
}

function layerOf(session: XRSession, xr: Viewer['renderer']['xr']): HeadsetLayer {
  const layer = xr.getBaseLayer();
  const { depthNear, depthFar } = session.renderState;
  const projection = 'textureWidth' in layer;
  return {
    kind: projection ? 'projection' : 'webgl',
    width: projection ? layer.textureWidth : layer.framebufferWidth,
    height: projection ? layer.textureHeight : layer.framebufferHeight,
    views: xr.getCamera().cameras.length,
    foveation: layer.fixedFoveation ?? null,
    depth_near: depthNear,
    depth_far: depthFar,
  };
}
