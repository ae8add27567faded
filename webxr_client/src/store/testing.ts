/** Values of the store for tests. */
import type { SequenceSummary } from './types';

/** A sound recording of one frame in the list. */
export function recordingRow(id: string, name = id): SequenceSummary {
  return {
    id,
    name,
    frames: 1,
    fps: 1,
    points: 1,
    damaged: null,
    labels_missing: null,
    created: null,
    changed: null,
    labelled: 0,
    labels: 0,
    labels_used: 0,
    identity: null,
    project: 'default',
    copy_of: null,
    bounds: { lo: [0, 0, 0], hi: [0, 0, 0] },
    fields: ['xyz'],
    revision: 0,
    shift: [0, 0, 0],
    room: [],
    position_error: 0,
    dropped: [0],
    large: false,
    source: '',
    deleted: null,
    until: null,
    sensors: [],
  };
}
