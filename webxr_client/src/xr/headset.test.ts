import { PerspectiveCamera } from 'three';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { Engine } from '../engine/engine';
import { actions } from '../store/actions';
import { state } from '../store/state';
import { Headset } from './headset';

/** A browser with these modes; its sessions end on request. */
function browser(modes: readonly string[]) {
  const ended: (() => void)[] = [];
  const offer = { take: (): void => undefined };
  const session = {
    addEventListener: (type: string, run: () => void) => type === 'end' && ended.push(run),
    requestReferenceSpace: () => Promise.resolve({}),
    end: vi.fn(() => {
      for (const run of ended) run();
      return Promise.resolve();
    }),
  };
  const xr = {
    addEventListener: () => undefined,
    isSessionSupported: (mode: string) => Promise.resolve(modes.includes(mode)),
    requestSession: vi.fn(() => Promise.resolve(session)),
    offerSession: vi.fn(() => new Promise((taken) => (offer.take = () => taken(session)))),
  };
  vi.stubGlobal('navigator', { xr });
  vi.stubGlobal('document', { documentElement: { toggleAttribute: () => false } });
  return { xr, session, offer };
}

/** An engine with a renderer that refuses sessions. */
function engine(): Engine {
  const refused = (): Promise<never> => Promise.reject(new Error('no layer for this display'));
  const nothing = (): void => undefined;
  const xr = {
    setSession: refused,
    setReferenceSpaceType: nothing,
    setFramebufferScaleFactor: nothing,
  };
  return {
    viewer: {
      camera: new PerspectiveCamera(),
      renderer: { xr },
      backdrop: { showSky: () => undefined },
      invalidate: () => undefined,
    },
    pacing: { show: () => undefined },
  } as unknown as Engine;
}

afterEach(() => vi.unstubAllGlobals());

describe('the headset', () => {
  it('ends a session that does not begin, says why, and can be entered again', async () => {
    const { session, xr } = browser(['immersive-vr', 'immersive-ar']);
    new Headset(engine());
    await vi.waitFor(() => expect(state.xr.peek().supported).toBe(true));
    await actions.page.enterVR();
    expect(session.end).toHaveBeenCalledOnce();
    expect(state.xr.peek()).toMatchObject({ session: 'none', detail: 'no layer for this display' });
    expect(state.notices.peek().at(-1)?.title).toBe('The headset session did not start');
    await actions.page.enterVR();
    expect(xr.requestSession).toHaveBeenCalledTimes(2);
  });

  it('enters with the real room in sight where a device has nothing else', async () => {
    const { xr } = browser(['immersive-ar']);
    new Headset(engine());
    await vi.waitFor(() =>
      expect(state.xr.peek()).toMatchObject({ supported: true, enters: 'AR', passthrough: false }),
    );
    await actions.page.enterVR();
    expect(xr.requestSession).toHaveBeenCalledWith('immersive-ar', expect.anything());
  });

  it('lets the browser offer a session, takes it, and offers again once it has ended', async () => {
    const { offer, session, xr } = browser(['immersive-vr']);
    new Headset(engine());
    await vi.waitFor(() => expect(xr.offerSession).toHaveBeenCalledOnce());
    offer.take();
    await vi.waitFor(() => expect(session.end).toHaveBeenCalledOnce());
    await vi.waitFor(() => expect(xr.offerSession).toHaveBeenCalledTimes(2));
    expect(xr.requestSession).not.toHaveBeenCalled();
  });
});
