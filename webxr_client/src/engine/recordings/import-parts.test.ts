import { afterEach, expect, test, vi } from 'vitest';
import { state } from '../../store/state';
import {
  cancelImport,
  mayBeSeveral,
  partsOfEntries,
  partsOfFiles,
  takeParts,
} from './import-parts';
import { importName, isOneOfSeveral, joinImports, ownImports } from './imports';
import { noteJob } from './recordings';

const api = vi.hoisted(() => vi.fn());

vi.mock('../../net/rest', async (original) => ({
  ...(await original<typeof import('../../net/rest')>()),
  api,
}));

const chosen = (...paths: string[]): { file: File; path: string }[] =>
  paths.map((path) => ({ file: new File(['1234'], path), path }));

afterEach(() => {
  state.jobs.value = [];
  joinImports([]);
  vi.clearAllMocks();
});

test('files of a folder are recordings by their folders, or by themselves', () => {
  const drives = chosen('in/drive 10/0.bin', 'in/drive 10/1.bin', 'in/drive 2/0.bin');
  expect(partsOfFiles(drives).map(({ name, bytes }) => [name, bytes])).toEqual([
    ['drive 2', 4],
    ['drive 10', 8],
  ]);
  expect(partsOfFiles(drives)[0]!.files![0]!.path).toBe('drive 2/0.bin');
  expect(partsOfFiles(chosen('a.ply', 'b.ply')).map(({ name }) => name)).toEqual(['a', 'b']);
  expect(mayBeSeveral(drives)).toBe(true);
  expect(mayBeSeveral(chosen('a.ply', 'b.ply'))).toBe(false);
  // Folders of different kinds are parts of one recording.
  expect(mayBeSeveral(chosen('k/velodyne/0.bin', 'k/image_2/0.png'))).toBe(false);
});

test('several recordings are one group, and one that is not asked for yet can be stopped', async () => {
  const parts = partsOfEntries(
    ['a', 'b', 'c', 'd'].map((name) => ({ name, path: `/in/${name}`, bytes: 1 })),
  ).map((part) => ({ ...part, included: part.name !== 'd' }));
  api.mockImplementation((_: string, __: string, { id, path }: Record<string, string>) => {
    if (path === '/in/b') return Promise.reject(new Error('no room'));
    // The message of the end comes before the answer to the call.
    noteJob({ ...ownImports.value.find((job) => job.id === id)!, state: 'done', sequence: 'a' });
    return Promise.resolve({ id, kind: 'import', state: 'queued', owner: '', sequence: 'a' });
  });
  const taken = takeParts(parts, {});
  cancelImport(ownImports.value[2]!);
  await taken;
  expect(ownImports.value.map(({ state: kind }) => kind)).toEqual(['done', 'failed', 'cancelled']);
  expect(ownImports.value.map(importName)).toEqual(['a', 'b', 'c']);
  expect(ownImports.value.every(isOneOfSeveral)).toBe(true);
  expect(api).toHaveBeenCalledTimes(2);
});
