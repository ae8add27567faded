/** The headset session: whether there can be one, its beginning and its end. */
import { Matrix4 } from 'three';
import { bindActions } from '../store/actions';
import type { Engine } from '../engine/engine';
import { follow, peek } from '../store/watch';
import { isStroke, notify, patch, state } from '../store/state';
import { Cockpit } from './cockpit';
import { layersWanted, present } from './layers';
import { Poses } from './input/poses';
import { RefreshRate } from './refresh';
import { xrSettings } from '../store/xr-settings';

type Mode = 'immersive-vr' | 'immersive-ar';

const FEATURES = ['local-floor', 'bounded-floor'] as const;

/** Features asked of a session: browsers may ask the person about hands, so only where they are wanted. */
export function wanted(): XRSessionInit {
  const { hands } = peek(xrSettings);
  const layers = layersWanted() ? ['layers'] : [];
  return { optionalFeatures: [...FEATURES, ...layers, ...(hands ? ['hand-tracking'] : [])] };
}

/** More pictures a second than this are not worth points. */
const BEST_RATE = 90;
const DEFAULT_RATE = 72;

/** Browsers that can offer a session beside the page's address (WebXR: `offerSession`). */
type Offering = XRSystem & {
  offerSession?(mode: Mode, init: XRSessionInit): Promise<XRSession>;
};

const NO_WEBXR = 'This browser has no WebXR. Open this page in the headset’s own browser.';
const NOT_SECURE = 'WebXR works only over HTTPS. Start the server with --tls, or open localhost.';
const NO_HEADSET = 'Connect a headset, or open this page in the browser of the headset.';

export class Headset {
  cockpit: Cockpit | null = null;
  private session: XRSession | null = null;
  private leaving = false;
  /** An offer stands in the browser's own bar. */
  private offered = false;
  private unsubscribe: (() => void) | null = null;
  /** Reason why the session that ends now could not begin. */
  private trouble = '';
  /** Pose of the desk's camera before, and its near and far plane. */
  private readonly desk = new Matrix4();
  private readonly planes = { near: 0, far: 0 };

  constructor(private readonly engine: Engine) {
    bindActions({
      page: {
        enterVR: (passthrough) => {
          const ar = passthrough || state.xr.peek().enters === 'AR';
          return this.enter(ar ? 'immersive-ar' : 'immersive-vr');
        },
        exitVR: () => this.exit(),
      },
    });
    const { xr } = navigator;
    if (!xr) {
      const detail = isSecureContext ? NO_WEBXR : NOT_SECURE;
      patch(state.xr, { supported: false, detail });
      return;
    }
    // An invisible page costs frames: its panels are hidden during a session.
    follow(() => {
      const presenting = state.xr.value.session === 'running';
      document.documentElement.toggleAttribute('data-presenting', presenting);
      if (state.xr.value.session !== 'running') void this.offer(xr);
    });
    // A session keeps drawing into the lost context: only a new one shows anything again.
    follow(() => {
      if (state.pictureLost.value) void this.session?.end().catch(() => undefined);
    });
    xr.addEventListener('devicechange', () => void this.look(xr));
    void this.look(xr);
  }

  /** Query the browser's supported modes. */
  private async look(xr: XRSystem): Promise<void> {
    const isSupported = (mode: Mode): Promise<boolean> =>
      xr.isSessionSupported(mode).catch(() => false);
    const [vr, ar] = await Promise.all([isSupported('immersive-vr'), isSupported('immersive-ar')]);
    const supported = vr || ar;
    const enters = ar && !vr ? 'AR' : 'VR';
    const detail = supported ? '' : NO_HEADSET;
    const idle = state.xr.peek().session === 'none';
    patch(state.xr, { supported, enters, passthrough: vr && ar, ...(idle ? { detail } : {}) });
  }

  /** Let the browser offer to enter, beside the page's address or in its own menu. */
  private async offer(xr: Offering): Promise<void> {
    const { supported, enters, session } = state.xr.peek();
    if (!xr.offerSession || this.offered || !supported || session === 'starting') return;
    const mode = enters === 'AR' ? 'immersive-ar' : 'immersive-vr';
    this.offered = true;
    const taken = await xr.offerSession(mode, wanted()).catch(() => null);
    this.offered = false;
    // Entered by the button, the browser takes its offer back.
    if (!taken) return;
    patch(state.xr, { session: 'starting', detail: '' });
    await this.attempt(() => this.begin(taken, mode));
  }

  async enter(mode: Mode = 'immersive-vr'): Promise<void> {
    const { xr } = navigator;
    if (!xr || state.xr.peek().session === 'running' || state.xr.peek().session === 'starting')
      return;
    patch(state.xr, { session: 'starting', detail: '' });
    await this.attempt(async () => this.begin(await xr.requestSession(mode, wanted()), mode));
  }

  private async attempt(begin: () => Promise<void>): Promise<void> {
    this.trouble = '';
    try {
      await begin();
    } catch (error) {
      await this.giveUp(error instanceof Error ? error.message : String(error));
    }
  }

  /** End a session that failed to start, so that no empty session remains. */
  private async giveUp(detail: string): Promise<void> {
    this.leaving = true;
    this.trouble = detail;
    await this.session?.end().catch(() => undefined);
    patch(state.xr, { session: 'none', detail });
    notify('error', 'The headset session did not start', detail);
  }

  private async begin(session: XRSession, mode: Mode): Promise<void> {
    const { viewer, pacing } = this.engine;
    const { xr } = viewer.renderer;
    this.leaving = false;
    this.session = session;
    viewer.camera.updateMatrix();
    this.desk.copy(viewer.camera.matrix);
    this.planes.near = viewer.camera.near;
    this.planes.far = viewer.camera.far;
    session.addEventListener('end', () => this.ended(), { once: true });
    const floor = await hasFloor(session);
    xr.enabled = true;
    xr.setReferenceSpaceType(floor ? 'local-floor' : 'local');
    xr.setFramebufferScaleFactor(peek(xrSettings).sharpness);
    await present(xr, session);
    pacing.show(1000 / (session.frameRate ?? DEFAULT_RATE));
    session.addEventListener('frameratechange', () => this.paceBy(session, DEFAULT_RATE));
    void chooseRate(session).then((rate) => this.paceBy(session, rate));
    const stopMeasuring = this.measureRate(session);
    session.addEventListener('end', stopMeasuring, { once: true });
    viewer.backdrop.showSky(mode === 'immersive-vr');
    const poses = new Poses(await session.requestReferenceSpace('viewer'));
    // It may have ended while it began.
    if (this.session !== session) return;
    this.unsubscribe = this.followEdges();
    this.cockpit = new Cockpit(this.engine, session, poses, floor, mode);
    // At the desk one may have been looking about; here one walks.
    if (!isStroke(state.tool.peek())) state.tool.value = 'paint';
    patch(state.xr, { session: 'running', detail: '' });
  }

  /** Let pictures be in time for the session's rate, or for `otherwise` where it tells none. */
  private paceBy(session: XRSession, otherwise: number): void {
    if (this.session === session) this.engine.pacing.show(1000 / (session.frameRate ?? otherwise));
  }

  /** Measure the rate by the pictures' own times, where the browser tells none; returns a function that ends it. */
  private measureRate(session: XRSession): () => void {
    if (session.frameRate) return () => undefined;
    const refresh = new RefreshRate();
    const stop = this.engine.viewer.ticks.add((now) => {
      if (!refresh.note(now)) return;
      stop();
      this.paceBy(session, refresh.rate);
    });
    return stop;
  }

  /** Draw the edges as coarse as is wished; the budget of points begins anew with each change. */
  private followEdges(): () => void {
    const { viewer, pacing } = this.engine;
    let before = NaN;
    return follow(() => {
      const { foveation } = xrSettings.value;
      if (foveation === before) return;
      before = foveation;
      viewer.renderer.xr.setFoveation(foveation);
      pacing.reset();
    });
  }

  async exit(): Promise<void> {
    this.leaving = true;
    await this.engine.viewer.renderer.xr.getSession()?.end();
  }

  private ended(): void {
    const { viewer, pacing } = this.engine;
    this.session = null;
    this.unsubscribe?.();
    this.unsubscribe = null;
    this.cockpit?.dispose();
    this.cockpit = null;
    const { position, quaternion, scale } = viewer.camera;
    this.desk.decompose(position, quaternion, scale);
    Object.assign(viewer.camera, this.planes);
    viewer.camera.updateProjectionMatrix();
    viewer.renderer.xr.enabled = false;
    viewer.backdrop.showSky(true);
    pacing.show(0);
    viewer.invalidate();
    if (this.leaving) {
      patch(state.xr, { session: 'none', detail: this.trouble });
      return;
    }
    const reason = state.pictureLost.peek()
      ? 'The graphics card stopped drawing.'
      : 'The headset was taken off or disconnected.';
    const detail = `${reason} All strokes are kept; enter again to continue.`;
    patch(state.xr, { session: 'lost', detail });
    notify('info', 'The headset session ended', detail);
  }
}

async function hasFloor(session: XRSession): Promise<boolean> {
  try {
    await session.requestReferenceSpace('local-floor');
    return true;
  } catch {
    return false;
  }
}

/** Request the best useful frame rate and return the actual one; some browsers never answer. */
async function chooseRate(session: XRSession): Promise<number> {
  const rates = session.supportedFrameRates;
  if (!rates) return session.frameRate ?? DEFAULT_RATE;
  const best = Math.max(0, ...[...rates].filter((rate) => rate <= BEST_RATE));
  try {
    if (best > 0) await session.updateTargetFrameRate(best);
  } catch {
    // The browser decides; its own rate is fine too.
  }
  return session.frameRate ?? (best || DEFAULT_RATE);
}
