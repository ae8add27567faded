import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { SequenceInfo } from '../../protocol/messages';
import { onPage, orderCounts } from '../../panels/importing/found';
import { state } from '../../store/state';
import { correctImport, importFiles, takeImport } from './importing';

const upload = vi.hoisted(() => vi.fn());

vi.mock('../../net/rest', async (original) => ({
  ...(await original<typeof import('../../net/rest')>()),
  upload,
}));

const REFUSED = 'expected files of frames, got 1 of no frame: b.label; (--by-order)';
const FOUND = {
  labelled: 1200, changed: 1100, matched: 2, labels: { 1: 1200 }, new_labels: [],
  unknown_classes: [], unmatched_frames: [], unmatched_files: [], locked: ['wall'], warnings: [],
  files: [{ file: 'a.label', frame: 0 }, { file: 'b.label', frame: 2 }],
}; // prettier-ignore

beforeEach(() => {
  state.sequence.value = { id: 'wall', name: 'Wall' } as SequenceInfo;
  state.notices.value = [];
  upload.mockImplementation((_: string, form: FormData) =>
    Promise.resolve(
      form.get('by_order') === 'true'
        ? { id: 'job', kind: 'import', state: 'done', result: FOUND }
        : { id: 'job', kind: 'import', state: 'failed', error: REFUSED },
    ),
  );
});
afterEach(() => {
  state.importing.value = null;
  vi.clearAllMocks();
});

describe('labels whose files have the names of no frame', () => {
  it('come in by their order once somebody says so, and what went where is told', async () => {
    await importFiles([{ file: new File(['x'], 'b.label'), path: 'b.label' }]);
    const draft = state.importing.value!;
    expect(orderCounts(draft)).toBe(true);
    expect(onPage(draft.error)).toBe('expected files of frames, got 1 of no frame: b.label;');
    await correctImport({ by_order: true });
    expect(state.importing.value).toMatchObject({ error: '', labels: { files: FOUND.files } });
    await takeImport();
    const [path, form] = upload.mock.lastCall as [string, FormData];
    expect([path, form.get('by_order')]).toEqual(['sequences/wall/annotations', 'true']);
    expect(state.notices.value).toMatchObject([
      {
        kind: 'success',
        detail:
          '1\u202f100 points in 2 frames. a.label → 0, b.label → 2. Locked labels kept their points: wall',
      },
    ]);
  });
});
