import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { keep } from '../store/kept';
import { wanted } from './headset';
import { present } from './layers';

const session = Object.create(null) as XRSession;
let kept: Map<string, string>;

/** A renderer that uses layers wherever their API is, and fails with them. */
function renderer(fails = true) {
  const tried: boolean[] = [];
  return {
    tried,
    setSession: () => {
      const layers = 'createProjectionLayer' in (globalThis as never as { XRWebGLBinding: { prototype: object } }).XRWebGLBinding.prototype;
      tried.push(layers);
      return layers || !fails ? Promise.reject(new Error('not supported')) : Promise.resolve();
    },
  };
} // prettier-ignore

beforeEach(() => {
  kept = new Map();
  vi.stubGlobal('localStorage', {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => kept.set(key, value),
  });
  keep('pointbrush.layers', '');
  vi.stubGlobal('XRWebGLBinding', class { createProjectionLayer(): void {} }); // prettier-ignore
});
afterEach(() => vi.unstubAllGlobals());

it('a session that fails with layers begins without them, and the next one does so at once', async () => {
  expect(wanted().optionalFeatures).toContain('layers');
  const first = renderer();
  await present(first, session);
  expect(first.tried).toEqual([true, false]);
  expect(wanted().optionalFeatures).not.toContain('layers');
  vi.stubGlobal('XRWebGLBinding', class { createProjectionLayer(): void {} }); // prettier-ignore
  const next = renderer();
  await present(next, session);
  expect(next.tried).toEqual([false]);
});

it('a session that fails without layers as well says why, and layers are asked for again', async () => {
  const both = renderer(false);
  await expect(present(both, session)).rejects.toThrow('not supported');
  expect(both.tried).toEqual([true, false]);
  await expect(present(both, session)).rejects.toThrow('not supported');
  expect(both.tried).toHaveLength(3);
  expect(wanted().optionalFeatures).toContain('layers');
});
