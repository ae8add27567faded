import type { ExportFormat } from '../../protocol/values';
import { describe, expect, it } from 'vitest';
import { groupFormats, lastExport, rememberExport } from './export-formats';
import { kept } from '../../store/kept';

function format(name: string, purpose: string, whole_boxes = false): ExportFormat {
  return {
    format: name,
    title: name.toUpperCase(),
    content: '',
    purpose,
    cannot_hold: [],
    splits: false,
    classes: false,
    whole_boxes,
  };
}

const FORMATS = [
  format('ply', 'points with labels'),
  format('kitti', 'boxes', true),
  format('pointcept', 'training sets'),
  format('whole', 'training sets', true),
  format('las', 'points with labels'),
];

function names(withBoxes: boolean): Record<string, string[]> {
  const groups = groupFormats(FORMATS, withBoxes);
  return Object.fromEntries(
    groups.map(({ purpose, formats }) => [purpose, formats.map((each) => each.format)]),
  );
}

describe('export formats', () => {
  it('are grouped by purpose in the order of the server', () => {
    const groups = names(true);
    expect(Object.keys(groups)).toEqual(['points with labels', 'boxes', 'training sets']);
    expect(groups['points with labels']).toEqual(['ply', 'las']);
    expect(groups['training sets']).toEqual(['pointcept', 'whole']);
  });

  it('of whole boxes are not offered for a recording without boxes', () => {
    expect(names(false)).toEqual({
      'points with labels': ['ply', 'las'],
      'training sets': ['pointcept'],
    });
  });

  it('used last are remembered by this browser', () => {
    rememberExport('las');
    expect(lastExport.value).toBe('las');
    expect(kept('pointbrush.last-export')).toBe('las');
  });
});
