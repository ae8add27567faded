import { describe, expect, it, vi } from 'vitest';
import { PREVIEW } from '../cloud/picture/palette';
import { frameOf, wall } from '../cloud/points/testing';
import type { Ask, Brush, Candidates, ClientMessage } from '../protocol/messages';
import { RegionPreview } from './region';

const brush: Brush = { label: 2, tool: 'paint', shape: 'plane' };
const SAMPLE = { origin: [0.1, 0.2, 0], direction: [0, 0, 1] } as const;

function setUp() {
  const frame = frameOf(wall(40, 1000));
  const sent: Ask[] = [];
  const preview = new RegionPreview({
    send: (message: ClientMessage) => void sent.push(message as Ask),
    frame: () => frame,
    brush: () => brush,
    shift: () => [100, 0, 0],
    changed: vi.fn(),
  });
  const answer = (points: number): void => preview.onCandidates(regionOf(sent.at(-1)!, points));
  return { frame, sent, preview, answer };
}

function regionOf({ id }: Ask, points: number): Candidates {
  const runs = new Uint8Array(Uint32Array.of(10, points).buffer);
  const candidates = points > 0 ? [{ id: 'one', level: 0, score: 1, points, runs }] : [];
  return { type: 'candidates', id, frame: 0, first: 0, ready: true, candidates };
}

describe('the preview of a region under a still hand', () => {
  it('is asked again when labels of the frame change, and shows the new answer', () => {
    const { frame, sent, preview, answer } = setUp();
    preview.hover(SAMPLE);
    answer(30);
    expect(frame.labelOf(30)).toBe(PREVIEW);
    preview.onLabels(7);
    expect(sent).toHaveLength(1);
    preview.onLabels(0);
    expect(sent[1]).toMatchObject({ samples: sent[0]!.samples, brush });
    answer(5);
    expect([frame.labelOf(14), frame.labelOf(30)]).toEqual([PREVIEW, 0]);
  });

  it('is asked again where there was no region, and where the answer was on its way', () => {
    const { frame, sent, preview, answer } = setUp();
    preview.hover(SAMPLE);
    answer(0);
    preview.onLabels(0);
    preview.onLabels(0);
    answer(0);
    expect(sent).toHaveLength(3);
    answer(5);
    expect(sent).toHaveLength(3);
    expect(frame.labelOf(14)).toBe(PREVIEW);
  });

  it('is not asked for once the pointer has left', () => {
    const { sent, preview, answer } = setUp();
    preview.hover(SAMPLE);
    answer(30);
    preview.leave();
    preview.onLabels(0);
    expect(sent).toHaveLength(1);
  });
});
