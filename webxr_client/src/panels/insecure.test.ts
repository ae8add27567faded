import { describe, expect, it } from 'vitest';
import { headsetOf, securePage } from './insecure';

const QUEST =
  'Mozilla/5.0 (X11; Linux x86_64; Quest 3) AppleWebKit/537.36 (KHTML, like Gecko) ' +
  'OculusBrowser/37.0 Chrome/132.0 VR Safari/537.36';
const DESKTOP = 'Mozilla/5.0 (X11; Linux x86_64) AppleWebKit/537.36 Chrome/132.0 Safari/537.36';

describe('a headset’s browser', () => {
  it('is told apart from others by its name', () => {
    expect(headsetOf(QUEST)).toBe('Quest');
    expect(headsetOf('Mozilla/5.0 (Linux; Android 12; A8110) PicoBrowser/4.0')).toBe('Pico');
    expect(headsetOf('Mozilla/5.0 (Android 10; Mobile; rv:121.0) Wolvic/1.7')).toBe('headset');
    expect(headsetOf(DESKTOP)).toBeNull();
  });

  it('finds the same place over HTTPS', () => {
    const page = 'http://192.168.0.7:8080/?token=secret&sequence=a&frame=3&view=1,2,3,4,5,6';
    expect(securePage(page)).toBe('https://192.168.0.7:8080/?sequence=a&frame=3');
  });
});
