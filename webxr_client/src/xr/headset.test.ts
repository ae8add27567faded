import { PerspectiveCamera } from 'three';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { Engine } from '../engine/engine';
import { actions } from '../actions';
import { state } from '../state';
import { Headset } from './headset';

/** A browser that has these modes, and whose sessions end when they are told to. */
function browser(modes: readonly string[]) {
  const ended: (() => void)[] = [];
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
  };
  vi.stubGlobal('navigator', { xr });
  return { xr, session };
}

/** An engine whose renderer takes no session. */
function engine(): Engine {
  const refused = (): Promise<never> => Promise.reject(new Error('no layer for this display'));
  const xr = { setSession: refused, setReferenceSpaceType: () => undefined };
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
    await actions.enterVR();
    expect(session.end).toHaveBeenCalledOnce();
    expect(state.xr.peek()).toMatchObject({ session: 'none', detail: 'no layer for this display' });
    expect(state.notices.peek().at(-1)?.title).toBe('The headset session did not start');
    await actions.enterVR();
    expect(xr.requestSession).toHaveBeenCalledTimes(2);
  });

  it('enters with the real room in sight where a device has nothing else', async () => {
    const { xr } = browser(['immersive-ar']);
    new Headset(engine());
    await vi.waitFor(() =>
      expect(state.xr.peek()).toMatchObject({ supported: true, enters: 'AR', passthrough: false }),
    );
    await actions.enterVR();
    expect(xr.requestSession).toHaveBeenCalledWith('immersive-ar', expect.anything());
  });
});
