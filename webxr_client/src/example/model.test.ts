import { describe, expect, it } from 'vitest';
import { DOUBT, DOUBT_STEPS, PREDICTED } from '../cloud/picture/palette';
import type { Label } from '../protocol/messages';
import { coloursOf, countOf, idsOf, labelOf, predictionOf } from './model';

const SAID = {
  numbers: null,
  kind: Uint8Array.of(0, 1, 2, 2),
  confidence: Uint8Array.of(255, 255, 0, 128),
};

function label(id: number, name: string, category: string, color = '#112233'): Label {
  return { id, name, category, color, visible: true, locked: false, instance: 0 } as Label;
}

describe('what a classifier says of a frame', () => {
  it('has the colour of its class, and none where nothing was taught', () => {
    expect([...idsOf(SAID, 'classes')]).toEqual([0, PREDICTED, PREDICTED + 1, PREDICTED + 1]);
  });

  it('has the colour of its doubt', () => {
    expect([...idsOf(SAID, 'doubt')]).toEqual([0, DOUBT + DOUBT_STEPS - 1, DOUBT, DOUBT + 32]);
  });

  it('is read from the bytes of an answer', () => {
    const head = new TextEncoder().encode('{"points": 4} ');
    const bytes = Uint8Array.of(head.length, 0, 0, 0, ...head, ...SAID.kind, ...SAID.confidence);
    expect(predictionOf(bytes.buffer)).toEqual(SAID);
  });

  it('is read of a part of a large frame, with the numbers of its points', () => {
    const head = new TextEncoder().encode('{"points": 2, "part": true} ');
    const numbers = new Uint8Array(Uint32Array.of(7, 90_000).buffer);
    const bytes = Uint8Array.of(head.length, 0, 0, 0, ...head, ...numbers, 1, 2, 200, 100);
    const said = predictionOf(bytes.buffer);
    expect([...said.numbers!]).toEqual([7, 90_000]);
    expect([[...said.kind], [...said.confidence]]).toEqual([[1, 2], [200, 100]]); // prettier-ignore
  });

  it('is counted, with what is in doubt', () => {
    expect(countOf(SAID)).toEqual({ points: 3, unsure: 1 });
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
