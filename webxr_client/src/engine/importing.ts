/** Files that come in: what they are is shown first, can be corrected, and then they are taken. */
import type { Actions } from '../store/actions';
import { count as shown, plural } from '../common/format';
import { api, ApiError, upload } from '../net/rest';
import type { Job } from '../protocol/messages';
import {
  isActive,
  notify,
  state,
  type ChosenFile,
  type ImportDraft,
  type ImportOptions,
  type ImportPreview,
  type LabelsFound,
} from '../store/state';
import { FIRST, importInto } from './projects';
import {
  attempt,
  commonName,
  jobOf,
  noteJob,
  sequencePath,
  setUpload,
  waitedFor,
} from './recordings';

type ImportActions = Pick<
  Actions,
  'importPath' | 'importFiles' | 'correctImport' | 'retargetImport' | 'takeImport' | 'leaveImport'
>;
type JobAnswer = Omit<Job, 'type' | 'frame'> & { readonly result: unknown };

/** Milliseconds between looks at a job whose result is waited for. */
const LOOK = 200;
/** Endings of files that hold labels and no points. */
const LABELS = /(\.label|_lidarseg\.bin|_panoptic\.npz|(label|segm|annotation)[^/]*\.(npy|json))$/i;

/** Files that a short message names. */
const TOLD = 3;

/** Answers to earlier questions are of no interest. */
let asked = 0;

function change(patch: Partial<ImportDraft>): void {
  const draft = state.importing.peek();
  if (draft) state.importing.value = { ...draft, ...patch };
}

function formOf(files: readonly ChosenFile[], options: object): FormData {
  const form = new FormData();
  for (const { file, path } of files) form.append('files', file, path);
  for (const [name, value] of Object.entries(options)) form.append(name, String(value));
  return form;
}

async function send<T>(path: string, files: readonly ChosenFile[], options: object): Promise<T> {
  const name = commonName(files);
  const total = files.reduce((sum, { file }) => sum + file.size, 0);
  setUpload(name, { name, sent: 0, total });
  try {
    return await upload<T>(path, formOf(files, options), (sent) =>
      setUpload(name, { name, sent, total }),
    );
  } finally {
    setUpload(name, null);
  }
}

/** Ask what an import of the draft would do. */
async function preview(): Promise<void> {
  const draft = state.importing.peek();
  if (!draft) return;
  const turn = ++asked;
  change({ busy: true, error: '' });
  try {
    const { files, path, upload: sent, options } = draft;
    const found =
      files && !sent
        ? await send<ImportPreview>('imports/preview', files, options)
        : await api<ImportPreview>('POST', 'imports/preview', {
            ...(sent ? { upload: sent } : { path }),
            ...options,
          });
    if (turn === asked) change({ busy: false, found, upload: found.upload });
  } catch (error) {
    if (turn !== asked) return;
    const sent = error instanceof ApiError ? error.more['upload'] : null;
    change({
      busy: false,
      found: null,
      error: error instanceof Error ? error.message : String(error),
      upload: typeof sent === 'string' ? sent : draft.upload,
    });
  }
}

/** Ask what labels the files give the open recording; or, not `dry`, take them. */
async function labels(dry: boolean): Promise<LabelsFound> {
  const { files, sequence, options } = state.importing.peek()!;
  const path = `${sequencePath(sequence!)}/annotations${dry ? '?dry_run=true' : ''}`;
  const id = crypto.randomUUID();
  waitedFor.add(id);
  let job = await send<JobAnswer>(path, files!, {
    id,
    ...(options.by_order && { by_order: true }),
  });
  if (!dry) noteJob(jobOf(job));
  while (isActive(jobOf(job))) {
    await new Promise((done) => setTimeout(done, LOOK));
    job = await api<JobAnswer>('GET', `jobs/${job.id}`);
  }
  if (job.state !== 'done') throw new ApiError('Labels', job.error ?? job.message, 422);
  return job.result as LabelsFound;
}

async function lookForLabels(): Promise<void> {
  const turn = ++asked;
  change({ busy: true, error: '', labels: null });
  try {
    const found = await labels(true);
    if (turn === asked) change({ busy: false, labels: found });
  } catch (error) {
    if (turn === asked) {
      change({ busy: false, error: error instanceof Error ? error.message : String(error) });
    }
  }
}

function look(): Promise<void> {
  return state.importing.peek()?.sequence ? lookForLabels() : preview();
}

function begin(draft: Pick<ImportDraft, 'files' | 'path' | 'sequence' | 'options'>): Promise<void> {
  const project = importInto.peek();
  state.importing.value = {
    ...draft,
    options: project === FIRST ? draft.options : { project, ...draft.options },
    upload: null,
    found: null,
    labels: null,
    busy: true,
    error: '',
  };
  return look();
}

function importFiles(files: readonly ChosenFile[], options: ImportOptions = {}): Promise<void> {
  const open = state.sequence.peek();
  const areLabels = files.every(({ path }) => LABELS.test(path));
  const name = options.name ?? commonName(files);
  return begin({
    files,
    path: null,
    sequence: open && areLabels ? open.id : null,
    options: { ...options, name },
  });
}

async function leave(): Promise<void> {
  const draft = state.importing.peek();
  asked++;
  state.importing.value = null;
  // An upload that nobody takes is removed by the server after a while.
  if (draft?.upload) await api('DELETE', `imports/${draft.upload}`).catch(() => undefined);
}

/** Outcome of an import of label files, in words. */
export function outcome({ changed, matched, files, locked }: LabelsFound): string {
  const count = `${shown(changed)} points in ${plural(matched, 'frame')}`;
  const pairs = files.slice(0, TOLD).map(({ file, frame }) => `${file} → ${frame}`);
  if (files.length > TOLD) pairs.push(`${files.length - TOLD} more`);
  const kept = locked.length > 0 ? [`Locked labels kept their points: ${locked.join(', ')}`] : [];
  return [count, pairs.join(', '), ...kept].filter(Boolean).join('. ');
}

async function take(): Promise<void> {
  const draft = state.importing.peek();
  if (!draft || draft.busy) return;
  if (draft.sequence) {
    change({ busy: true });
    const found = await labels(false).finally(() => (state.importing.value = null));
    notify('success', 'Labels imported', outcome(found));
    return;
  }
  const source = draft.upload ? { upload: draft.upload } : { path: draft.path };
  const job = await api<JobAnswer>('POST', 'sequences', { ...source, ...draft.options });
  state.importing.value = null;
  noteJob(jobOf(job));
}

export const importActions: ImportActions = {
  importPath: (path, options = {}) => begin({ files: null, path, sequence: null, options }),
  importFiles,
  correctImport: (patch) => {
    const draft = state.importing.peek();
    if (!draft) return Promise.resolve();
    const options = Object.fromEntries(
      Object.entries({ ...draft.options, ...patch }).filter(([, value]) => value !== null),
    );
    change({ options });
    return look();
  },
  retargetImport: (sequence) => {
    change({ sequence });
    return look();
  },
  takeImport: () => attempt('The import did not start', take),
  leaveImport: leave,
};
