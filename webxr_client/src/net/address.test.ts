import { describe, expect, it } from 'vitest';
import { placeIn, withPlace, type Place } from './address';

const PLACE: Place = { frame: 12, label: 3, view: [1.5, 2, -0.25, 0, 1, 0] };

describe('the address', () => {
  it('gives back the place that was put in', () => {
    const address = withPlace('http://host/?sequence=a%20b&frame=1', PLACE);
    expect(address).toBe('http://host/?sequence=a+b&frame=12&label=3&view=1.5,2,-0.25,0,1,0');
    expect(placeIn(new URL(address).search)).toEqual(PLACE);
    expect(withPlace(address, { frame: 0, label: 0, view: null })).toBe(
      'http://host/?sequence=a+b&frame=0',
    );
  });

  it('says nothing where it makes no sense', () => {
    const nothing = { frame: 0, label: 0, view: null };
    for (const query of ['', '?frame=-1&label=x&view=1,2', '?frame=1e99&view=1,2,3,4,5,x']) {
      expect(placeIn(query)).toEqual(nothing);
    }
  });
});
