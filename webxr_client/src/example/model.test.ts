import { describe, expect, it } from 'vitest';
import { PREDICTED, SURE_STEPS } from '../cloud/picture/palette';
import type { Label } from '../protocol/messages';
import { coloursOf, idsOf, labelOf, mapColours, predictionOf, talliesOf } from './model';

const PREDICTION = {
  numbers: null,
  kind: Uint8Array.of(0, 1, 2, 2),
  confidence: Uint8Array.of(255, 255, 0, 128),
  confused: [[0, 1, 1]] as const,
  doubts: [0, 1],
};

function label(id: number, name: string, category: string, color = '#112233'): Label {
  return { id, name, category, color, visible: true, locked: false, instance: 0 } as Label;
}

describe('prediction of a frame', () => {
  it('has the colour of its class, the greyer the less certain, and none where nothing was taught', () => {
    const ids = [...idsOf(PREDICTION)];
    expect(ids).toEqual([0, PREDICTED + 3, PREDICTED + SURE_STEPS, PREDICTED + SURE_STEPS + 2]);
    const colours = mapColours(['#ff0000', '#0000ff'], null);
    expect(colours[ids[1]! - PREDICTED]).toBe('#ff0000');
    expect(colours[ids[3]! - PREDICTED]).not.toBe('#0000ff');
    expect(new Set(mapColours(['#ff0000', '#0000ff'], 1).slice(0, SURE_STEPS)).size).toBe(1);
  });

  it('is read from the bytes of an answer', () => {
    const head = new TextEncoder().encode(
      '{"points": 4, "confused": [[0, 1, 1]], "doubts": [0, 1]} ',
    );
    const bytes = Uint8Array.of(
      head.length,
      0,
      0,
      0,
      ...head,
      ...PREDICTION.kind,
      ...PREDICTION.confidence,
    );
    expect(predictionOf(bytes.buffer)).toEqual(PREDICTION);
  });

  it('is read of a part of a large frame, with the numbers of its points', () => {
    const head = new TextEncoder().encode('{"points": 2, "part": true} ');
    const numbers = new Uint8Array(Uint32Array.of(7, 90_000).buffer);
    const bytes = Uint8Array.of(head.length, 0, 0, 0, ...head, ...numbers, 1, 2, 200, 100);
    const prediction = predictionOf(bytes.buffer);
    expect([...prediction.numbers!]).toEqual([7, 90_000]);
    expect([[...prediction.kind], [...prediction.confidence]]).toEqual([[1, 2], [200, 100]]); // prettier-ignore
  });

  it('is counted by class, above a confidence and of some points', () => {
    const [all, ...each] = talliesOf(PREDICTION, 2);
    expect(all).toMatchObject({ points: 3, unsure: 1 });
    expect(each.map(({ points }) => points)).toEqual([1, 2]);
    expect(talliesOf(PREDICTION, 2, 100, (point) => point !== 1)[0]?.points).toBe(1);
  });
});

describe('the label that a class is predicted as', () => {
  const palette = [
    label(1, 'Car 1', 'car'),
    label(2, 'car', 'car', '#00ff00'),
    label(3, 'road', ''),
  ];

  it('is the one called like it before others of its category', () => {
    expect(labelOf('car', palette)?.id).toBe(2);
    expect(labelOf('road', palette)?.id).toBe(3);
    expect(labelOf('tree', palette)).toBeUndefined();
  });

  it('gives its colour', () => {
    expect(coloursOf(['car', 'tree'], palette)).toEqual(['#00ff00', '#8791a0']);
  });
});
