import { beforeEach, describe, expect, it } from 'vitest';
import {
  beginTour,
  leaveTour,
  placeCard,
  stepsFor,
  stepTour,
  tourIsNew,
  tourStep,
} from './tour-steps';

const WINDOW = { width: 1280, height: 720 };
const CARD = { width: 320, height: 150 };

function keepIn(storage: object): void {
  Object.defineProperty(globalThis, 'localStorage', { value: storage, configurable: true });
}

describe('the tour', () => {
  beforeEach(() => {
    const memory = new Map<string, string>();
    const getItem = (key: string) => memory.get(key) ?? null;
    keepIn({ getItem, setItem: (key: string, value: string) => void memory.set(key, value) });
    tourStep.value = null;
  });

  it('goes on and back, and does not come again once it is through', () => {
    const count = stepsFor(true).length;
    expect(count).toBe(5);
    expect(tourIsNew()).toBe(true);
    beginTour();
    stepTour(-1, count);
    expect(tourStep.value).toBe(0);
    for (let card = 1; card < count; card++) {
      stepTour(1, count);
      expect(tourStep.value).toBe(card);
    }
    expect(tourIsNew()).toBe(true);
    stepTour(1, count);
    expect(tourStep.value).toBeNull();
    expect(tourIsNew()).toBe(false);
    stepTour(1, count);
    expect(tourStep.value).toBeNull();
  });

  it('is left in the middle, and begun again when asked for', () => {
    beginTour();
    stepTour(1, 5);
    leaveTour();
    expect([tourStep.value, tourIsNew()]).toEqual([null, false]);
    beginTour();
    expect(tourStep.value).toBe(0);
  });

  it('leaves out what a viewer may not do', () => {
    expect(stepsFor(false).map(({ title }) => title)).toEqual(['Look around', 'Export']);
  });

  it('comes unasked in no browser that would forget it was left', () => {
    const refuse = (): never => {
      throw new Error('storage is switched off');
    };
    keepIn({ getItem: refuse, setItem: refuse });
    expect(tourIsNew()).toBe(false);
    beginTour();
    leaveTour();
    expect(tourStep.value).toBeNull();
  });
});

describe('a card', () => {
  it('lies below a control, with its tip at the middle of it', () => {
    const button = { left: 500, top: 8, width: 60, height: 28 };
    const { left, top, side, tip } = placeCard(button, CARD, WINDOW);
    expect([top, side, left + tip]).toEqual([48, 'below', 530]);
  });

  it('stays in the window at its right edge, and still points', () => {
    const button = { left: 1180, top: 8, width: 80, height: 28 };
    const { left, tip } = placeCard(button, CARD, WINDOW);
    expect(left + CARD.width).toBeLessThanOrEqual(WINDOW.width - 8);
    expect(left + tip).toBe(1220);
  });

  it('lies beside what reaches far down', () => {
    const panel = { left: 0, top: 90, width: 264, height: 484 };
    expect(placeCard(panel, CARD, WINDOW)).toEqual({ left: 276, top: 110, side: 'right', tip: 20 });
  });
});
