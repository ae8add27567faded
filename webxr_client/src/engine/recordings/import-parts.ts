/** Import of a folder with one recording in each entry. */
import type { Job } from '../../protocol/messages';
import type { Entry } from '../../protocol/values';
import { actions } from '../../store/actions';
import type { ChosenFile, ImportOptions, ImportPart } from '../../store/state';
import { dropUploads, submit } from './import-requests';
import { joinImports } from './imports';
import { commonName, noteJob } from './recordings';

const PART = { files: null, path: null, upload: null, found: null, error: '', included: true };

export function partsOfEntries(entries: readonly Entry[]): readonly ImportPart[] {
  return entries.map((entry) => ({ ...PART, ...entry }));
}

/** Chosen files, grouped by the first entry below their common folder. */
export function partsOfFiles(files: readonly ChosenFile[]): readonly ImportPart[] {
  const paths = files.map(({ path }) => path.split('/'));
  const shared = paths.every((path) => path.length > 1 && path[0] === paths[0]![0]) ? 1 : 0;
  const parts = new Map<string, ChosenFile[]>();
  files.forEach(({ file }, k) => {
    const path = paths[k]!.slice(shared);
    const part = parts.get(path[0]!) ?? [];
    part.push({ file, path: path.join('/') });
    parts.set(path[0]!, part);
  });
  const order = new Intl.Collator(undefined, { numeric: true });
  return [...parts.values()]
    .map((own) => {
      const bytes = own.reduce((sum, { file }) => sum + file.size, 0);
      return { ...PART, name: commonName(own), files: own, bytes };
    })
    .sort((a, b) => order.compare(a.name, b.name));
}

/** Whether files can be several recordings as well as one: they are in folders of one kind. */
export function mayBeSeveral(files: readonly ChosenFile[]): boolean {
  const ending = ({ path }: ChosenFile): string => path.slice(path.lastIndexOf('.'));
  const folders = partsOfFiles(files).filter(({ files: own }) => own![0]!.path.includes('/'));
  const kinds = folders.map(({ files: own }) => [...new Set(own!.map(ending))].sort().join());
  return kinds.length > 1 && new Set(kinds).size === 1;
}

/** Options of one of several recordings, which has a separate name. */
export function optionsOf({ files, name }: ImportPart, options: ImportOptions): ImportOptions {
  const shared = Object.fromEntries(Object.entries(options).filter(([key]) => key !== 'name'));
  return files ? { ...shared, name } : shared;
}

/** Whether several recordings can be imported: all included ones are on the server. */
export function areReady(parts: readonly ImportPart[]): boolean {
  const chosen = parts.filter(({ included }) => included);
  return chosen.length > 0 && chosen.every(({ path, upload }) => path ?? upload);
}

/** Imports that are on the card and not requested yet. */
const unsent = new Set<string>();

/** Import several recordings; their jobs are shown before the server answers. */
export async function takeParts(
  parts: readonly ImportPart[],
  options: ImportOptions,
): Promise<void> {
  const begun = parts
    .filter(({ included }) => included)
    .map((part) => ({ part, job: waiting(crypto.randomUUID()) }));
  joinImports(begun.map(({ part, job }) => [job.id, part.found?.name ?? part.name]));
  for (const { job } of begun) {
    unsent.add(job.id);
    noteJob(job);
  }
  for (const { part, job } of begun) {
    if (!unsent.delete(job.id)) continue;
    const failed = (error: unknown): Job => {
      return { ...job, state: 'failed', error: error instanceof Error ? error.message : null };
    };
    noteJob(await submit(part, optionsOf(part, options), job.id).catch(failed));
  }
  await dropUploads(parts.filter(({ included }) => !included));
}

function waiting(id: string): Job {
  const fields = { sequence: null, progress: 0, message: '', frame: null, error: null, edit: null };
  return { type: 'job', id, kind: 'import', state: 'queued', owner: '', ...fields };
}

export function cancelImport(job: Job): void {
  if (unsent.delete(job.id)) noteJob({ ...job, state: 'cancelled' });
  else void actions.tracking.cancelJob(job.id);
}
