/** Import of files: preview, corrections, and the import itself. */
import { count as shown, plural } from '../../common/format';
import { api } from '../../net/rest';
import type { Entry, ImportedLabels, Job as RestJob } from '../../protocol/values';
import {
  notify,
  state,
  type ChosenFile,
  type ImportDraft,
  type ImportOptions,
  type ImportPart,
} from '../../store/state';
import {
  areReady,
  mayBeSeveral,
  optionsOf,
  partsOfEntries,
  partsOfFiles,
  takeParts,
} from './import-parts';
import { dropUploads, previewOf, send, submit } from './import-requests';
import { joinImports } from './imports';
import { FIRST, importInto } from './projects';
import { attempt, commonName, finished, jobOf, noteJob, sequencePath } from './recordings';

/** Endings of files that hold labels and no points. */
const LABELS =
  /(\.label|_lidarseg\.bin|_panoptic\.npz|(label|segm|annotation|instances)[^/]*\.(npy|json)|(mask|label|segm)[^/]*(\/[^/]+)*\.(png|txt|json)|\/?classes\.(txt|json))$/i;

/** Files that a short message names. */
const MAX_NAMED_FILES = 3;

/** Number of the newest request; answers to earlier ones are ignored. */
let newestRequest = 0;

function change(patch: Partial<ImportDraft>): void {
  const draft = state.importing.peek();
  if (draft) state.importing.value = { ...draft, ...patch };
}

async function preview(): Promise<void> {
  const draft = state.importing.peek();
  if (!draft) return;
  const turn = ++newestRequest;
  change({ busy: true, error: '' });
  if (!draft.parts) {
    const answer = await previewOf(draft, draft.options);
    if (turn === newestRequest) change({ busy: false, ...answer });
    return;
  }
  for (const [number, part] of draft.parts.entries()) {
    const answer = await previewOf(part, optionsOf(part, draft.options));
    if (turn !== newestRequest) return;
    const { included, error } = state.importing.peek()!.parts![number]!;
    // Unreadable parts are left out, and included again once they can be read.
    changePart({ ...answer, included: !answer.error && (included || error !== '') }, number);
  }
  change({ busy: false });
}

/** Change one of several recordings, or all. */
export function changePart(patch: Partial<ImportPart>, number?: number): void {
  const parts = state.importing.peek()?.parts;
  if (!parts) return;
  const of = (k: number): boolean => number === undefined || number === k;
  change({ parts: parts.map((part, k) => (of(k) ? { ...part, ...patch } : part)) });
}

/** Preview the labels that files give the open recording, or import them unless `dry`. */
async function labels(dry: boolean): Promise<ImportedLabels> {
  const { files, sequence, options } = state.importing.peek()!;
  const path = `${sequencePath(sequence!)}/annotations${dry ? '?dry_run=true' : ''}`;
  const id = crypto.randomUUID();
  const more = options.by_order && { by_order: true };
  const begun = send<RestJob>(path, files!, { id, ...more });
  if (!dry) void begun.then((job) => noteJob(jobOf(job)), () => undefined); // prettier-ignore
  const { result } = await finished(id, begun);
  return result as unknown as ImportedLabels;
}

async function lookForLabels(): Promise<void> {
  const turn = ++newestRequest;
  change({ busy: true, error: '', labels: null });
  try {
    const found = await labels(true);
    if (turn === newestRequest) change({ busy: false, labels: found });
  } catch (error) {
    if (turn === newestRequest) {
      change({ busy: false, error: error instanceof Error ? error.message : String(error) });
    }
  }
}

function look(): Promise<void> {
  return state.importing.peek()?.sequence ? lookForLabels() : preview();
}

async function begin(draft: Partial<ImportDraft>): Promise<void> {
  const project = importInto.peek();
  const { options } = draft;
  state.importing.value = {
    files: null,
    path: null,
    sequence: null,
    parts: null,
    decided: true,
    upload: null,
    found: null,
    labels: null,
    busy: false,
    error: '',
    ...draft,
    options: project === FIRST ? { ...options } : { project, ...options },
  };
  if (state.importing.peek()?.decided) await look();
}

/** Preview files; `takeImport` imports them. */
export function importFiles(
  files: readonly ChosenFile[],
  options: ImportOptions = {},
): Promise<void> {
  const open = state.sequence.peek();
  const areLabels = files.every(({ path }) => LABELS.test(path));
  const name = options.name ?? commonName(files);
  return begin({
    files,
    sequence: open && areLabels ? open.id : null,
    decided: areLabels || !mayBeSeveral(files),
    options: { ...options, name },
  });
}

/** Preview each entry in a folder of the server as a recording. */
export const importEach = (path: string): Promise<void> =>
  attempt('The folder was not read', async () => {
    const entries = await api<Entry[]>('POST', 'imports/entries', { path });
    await begin({ path, parts: partsOfEntries(entries) });
  });

export async function leaveImport(): Promise<void> {
  const draft = state.importing.peek();
  newestRequest++;
  state.importing.value = null;
  if (draft) await dropUploads([draft, ...(draft.parts ?? [])]);
}

/** Return the message about an import of label files. */
export function outcome({ changed, matched, files, locked }: ImportedLabels): string {
  const count = `${shown(changed)} points in ${plural(matched, 'frame')}`;
  const pairs = files.slice(0, MAX_NAMED_FILES).map(({ file, frame }) => `${file} → ${frame}`);
  if (files.length > MAX_NAMED_FILES) pairs.push(`${files.length - MAX_NAMED_FILES} more`);
  const kept = locked.length > 0 ? [`Locked labels kept their points: ${locked.join(', ')}`] : [];
  return [count, pairs.join(', '), ...kept].filter(Boolean).join('. ');
}

export const takeImport = (): Promise<void> => attempt('The import did not start', take);

async function take(): Promise<void> {
  const draft = state.importing.peek();
  if (!draft || (draft.parts ? !areReady(draft.parts) : draft.busy)) return;
  if (draft.sequence) {
    change({ busy: true });
    const found = await labels(false).finally(() => (state.importing.value = null));
    notify('success', 'Labels imported', outcome(found));
    return;
  }
  if (draft.parts) {
    newestRequest++;
    state.importing.value = null;
    await takeParts(draft.parts, draft.options);
    return;
  }
  const id = crypto.randomUUID();
  const job = await submit(draft, draft.options, id);
  joinImports([[id, draft.options.name ?? draft.found?.name ?? '']]);
  state.importing.value = null;
  noteJob(job);
}

/** Preview files on the server's machine; `takeImport` imports them. */
export function importPath(path: string): Promise<void> {
  return begin({ path, options: {} });
}

/** Correct the reading of the files; null takes an option back. */
export function correctImport(patch: Partial<Record<keyof ImportOptions, unknown>>): Promise<void> {
  const draft = state.importing.peek();
  if (!draft) return Promise.resolve();
  const options = Object.fromEntries(
    Object.entries({ ...draft.options, ...patch }).filter(([, value]) => value !== null),
  );
  change({ options });
  return look();
}

/** The files are labels of a recording, or (null) a new recording, or several. */
export function retargetImport(sequence: string | null, several = false): Promise<void> {
  const files = state.importing.peek()?.files ?? [];
  change({ sequence, decided: true, parts: several ? partsOfFiles(files) : null });
  return look();
}
