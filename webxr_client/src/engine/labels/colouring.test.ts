import { expect, it } from 'vitest';
import type { Label } from '../../protocol/messages';
import { state, type TimelineRow } from '../../store/state';
import { colouredLabels, confidenceColour, FADED, looked, mixed, PAINTED, provenanceColour, SURE, TRACKED, UNKNOWN, UNSURE } from './colouring'; // prettier-ignore

/** Painted, surely tracked, doubtful, half painted, absent. */
const row: TimelineRow = {
  points: Uint32Array.of(10, 10, 10, 10, 0),
  painted: Uint32Array.of(10, 0, 0, 5, 0),
  confidence: Float32Array.of(NaN, 1, 0, 1, NaN),
  state: Uint8Array.of(1, 2, 2, 2, 0),
};

it('colours labels by how sure tracking is of them', () => {
  const colours = [0, 1, 2, 4].map((frame) => confidenceColour(row, frame));
  expect(colours).toEqual([SURE, SURE, UNSURE, UNKNOWN]);
  expect(confidenceColour(undefined, 0)).toBe(UNKNOWN);
});

it('colours labels by where their points are from', () => {
  const colours = [0, 1, 3, 4].map((frame) => provenanceColour(row, frame));
  expect(colours).toEqual([PAINTED, TRACKED, mixed(TRACKED, PAINTED, 0.5), UNKNOWN]);
  expect(mixed('#000000', '#ff8000', 0.5)).toBe('#804000');
});

it('greys all labels but those of the class that is looked at', () => {
  state.palette.value = ['car', 'road'].map(
    (name, id) => ({ id, name, color: '#00ff00' }) as Label,
  );
  looked.value = ({ name }) => name === 'road';
  expect(colouredLabels().map(({ color }) => color)).toEqual([FADED, '#00ff00']);
  looked.value = null;
  expect(colouredLabels()).toBe(state.palette.value);
});
