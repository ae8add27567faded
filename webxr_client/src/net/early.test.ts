import { afterEach, describe, expect, it, vi } from 'vitest';
import { Early, firstOf } from './early';
import type { ToWorker } from './wire';

const sent: ToWorker[] = [];

class Silent {
  onmessage: unknown = null;
  postMessage(message: ToWorker): void {
    sent.push(message);
  }
}

function page(address: string, answer: () => Promise<Response>): Early {
  sent.length = 0;
  const location = new URL(address);
  vi.stubGlobal('Worker', Silent);
  vi.stubGlobal('location', location);
  vi.stubGlobal('document', { baseURI: location.href });
  vi.stubGlobal('history', { replaceState: vi.fn() });
  vi.stubGlobal('fetch', vi.fn(answer));
  return new Early();
}

function opened(): string[] {
  return sent.flatMap((message) => (message.t === 'open' ? [message.message.sequence] : []));
}

afterEach(() => vi.unstubAllGlobals());

describe('what goes out before the page has loaded', () => {
  const two = (): Promise<Response> => Promise.resolve(Response.json([{ id: 'a' }, { id: 'b' }]));

  it('opens the recording that the address names', async () => {
    const early = page('http://host/?sequence=b', two);
    expect(sent.some(({ t }) => t === 'connect')).toBe(true);
    expect(await early.opening).toBe('b');
    expect(opened()).toEqual(['b']);
  });

  it('opens nothing where a person has to choose, or the server says no', async () => {
    const gone = page('http://host/?sequence=gone', two);
    expect(await gone.opening).toBe(null);
    expect(gone.missing).toBe('gone');
    expect(opened()).toEqual([]);
    const refused = (): Promise<Response> => Promise.resolve(new Response('', { status: 401 }));
    expect(await page('http://host/?sequence=a', refused).opening).toBe(null);
    expect(opened()).toEqual([]);
  });

  it('asks nothing with a token that the server left in the address', async () => {
    const early = page('http://host/?token=wrong&sequence=a', two);
    expect(early.refused).toBe(true);
    expect(await early.opening).toBe(null);
    expect(sent.some(({ t }) => t === 'connect')).toBe(false);
  });

  it('opens the only recording there is', () => {
    vi.stubGlobal('document', { baseURI: 'http://host/' });
    vi.stubGlobal('location', new URL('http://host/'));
    expect(firstOf([{ id: 'only' }])).toBe('only');
    expect(firstOf([])).toBe(null);
    vi.stubGlobal('location', new URL('http://host/?sequence=gone'));
    expect(firstOf([{ id: 'only' }])).toBe(null);
  });
});
