/** Recordings: the list, export, change, delete. */
import { actions, type ActionParts } from '../../store/actions';
import { exportFormats, rememberExport } from './export-formats';
import { noteImport } from './imports';
import { listSequences } from '../../net/early';
import { api, apiUrl, ApiError } from '../../net/rest';
import type { Job } from '../../protocol/messages';
import type { ExportFormat, Job as RestJob } from '../../protocol/values';
import {
  isActive,
  notify,
  state,
  type ChosenFile,
  type DeletedSequence,
  type SequenceSummary,
  type Upload,
} from '../../store/state';

/** Do some work and return true, or show the server's error message. */
export async function succeeds(what: string, work: () => Promise<unknown>): Promise<boolean> {
  try {
    await work();
    return true;
  } catch (error) {
    const detail = error instanceof ApiError ? error.message : String(error);
    notify('error', what, detail);
    return false;
  }
}

/** The same where the outcome does not matter. */
export async function attempt(what: string, work: () => Promise<unknown>): Promise<void> {
  await succeeds(what, work);
}

/** Ids of awaited jobs: the caller reports their end, without a separate message. */
export const waitedFor = new Set<string>();

/** Milliseconds between two requests for the state of an awaited job. */
const LOOK_MS = 200;

/** Wait for the end of a job of an id that the caller chose, and reports; throws ApiError if it failed. */
export async function finished(id: string, begun: Promise<RestJob>): Promise<RestJob> {
  waitedFor.add(id);
  let job = await begun;
  while (isActive(jobOf(job))) {
    await new Promise((done) => setTimeout(done, LOOK_MS));
    job = await api<RestJob>('GET', `jobs/${job.id}`);
  }
  if (job.state !== 'done') throw new ApiError(job.kind, job.error ?? job.message, 422);
  return job;
}

/** Record the state of a job from the socket or an answer; the newest one wins. */
export function noteJob(job: Job): void {
  const known = state.jobs.peek().find((other) => other.id === job.id);
  // The answer to the call that began it can come after the message of its end.
  if (known && isActive(job) && !isActive(known)) return;
  const others = state.jobs.peek().filter((other) => other !== known);
  state.jobs.value = [...others, job];
  noteImport(job);
}

/** Time for which ends of several imports are collected before the list is fetched, milliseconds. */
const SOON_MS = 500;
let soon: ReturnType<typeof setTimeout> | null = null;

/** Fetch the list of recordings, once for all that is asked within a short time. */
export function refreshSoon(): void {
  soon ??= setTimeout(() => {
    soon = null;
    void actions.recordings.refreshSequences();
  }, SOON_MS);
}

export function setUpload(name: string, next: Upload | null): void {
  const others = state.uploads.peek().filter((other) => other.name !== name);
  state.uploads.value = next ? [...others, next] : others;
}

export function jobOf(answer: RestJob): Job {
  return { ...answer, type: 'job', frame: null, edit: null, owner: answer.owner ?? '' };
}

async function refreshSequences(): Promise<void> {
  const list = await listSequences();
  const rows = list.map((row): SequenceSummary => {
    return { ...row, points: row.points.reduce((most, count) => Math.max(most, count), 0) };
  });
  state.copies.value = rows.filter((row) => row.copy_of);
  state.sequences.value = rows.filter((row) => !row.copy_of);
}

/** Row of a recording, or of a copy; undefined where there is none. */
export function rowOf(id: string | undefined): SequenceSummary | undefined {
  const { sequences, copies } = state;
  return [...(sequences.value ?? []), ...copies.value].find((row) => row.id === id);
}

/** Take a deleted recording off the list at once: its picture is no longer to be had. */
export function leaveOut(id: string): void {
  state.sequences.value = state.sequences.peek()?.filter((row) => row.id !== id) ?? null;
}

export const refreshDeleted = (): Promise<void> =>
  attempt('The deleted recordings did not load', async () => {
    state.deleted.value = await api<DeletedSequence[]>('GET', 'sequences?deleted=true');
  });

/** The address of a recording, under the API's. */
export function sequencePath(id: string): string {
  return `sequences/${encodeURIComponent(id)}`;
}

/** The address of something in the open recording. */
export function openPath(rest: string): string {
  return `${sequencePath(state.sequence.peek()?.id ?? '')}/${rest}`;
}

/** Return a folder's name, a file's name without its ending, or the common prefix of files. */
function beginning(names: readonly string[]): string {
  const [first = '', ...others] = names.map((name) => name.replace(/\.[^.]+$/, ''));
  let length = first.length;
  for (const name of others) while (!name.startsWith(first.slice(0, length))) length--;
  return others.length > 0 ? first.slice(0, length).replace(/[\d\s._-]+$/, '') : first;
}

export function commonName(files: readonly ChosenFile[]): string {
  const first = files[0]?.path.split('/');
  if (!first) return 'recording';
  const name = first.length > 1 ? first[0]! : beginning(files.map(({ path }) => path));
  return name.slice(0, 200) || 'recording';
}

function download(href: string): void {
  const link = document.createElement('a');
  link.href = href;
  link.download = '';
  link.click();
}

export const loadExportFormats = (): Promise<void> =>
  attempt('The export formats did not load', async () => {
    exportFormats.value = await api<ExportFormat[]>('GET', 'exports');
  });

/**
 * Download labels; `frames` like "3:10", empty for all; `val`: frames for validation, or "none";
 * `snapshot`: id of the version of the labels; `id`: of a recording other than the open one.
 */
export const exportSequence = (
  format: string,
  frames = '',
  val = '',
  snapshot = '',
  id = state.sequence.peek()?.id,
): Promise<void> =>
  attempt('The export did not start', async () => {
    if (id === undefined) return;
    const query = new URLSearchParams({ format });
    if (frames) query.set('frames', frames);
    if (val) query.set('val', val);
    if (snapshot) query.set('snapshot', snapshot);
    // A failed or refused download reports no error: check with a request first.
    await api('GET', sequencePath(id));
    download(apiUrl(`${sequencePath(id)}/export?${query.toString()}`));
    rememberExport(format);
    notify('success', 'Export started', 'The browser saves the file in its downloads.');
  });

/** Recordings deleted on this page, so that the server's message is not shown again. */
export const deletedByPage = new Set<string>();

async function remove(id: string): Promise<void> {
  const name = state.sequences.peek()?.find((row) => row.id === id)?.name ?? id;
  deletedByPage.add(id);
  try {
    await api('DELETE', sequencePath(id));
  } catch (error) {
    deletedByPage.delete(id);
    throw error;
  }
  const wasOpen = state.sequence.peek()?.id === id;
  leaveOut(id);
  if (wasOpen) actions.recordings.closeSequence();
  const run = (): void =>
    void attempt('The recording was not restored', () => restore(id, wasOpen));
  notify('info', `Deleted ${name}`, 'It can be restored for 30 days.', { label: 'Undo', run });
  await refreshSequences();
  await refreshDeleted();
}

/** Bring a deleted recording back, by its import or its id, and open it again if it was. */
async function restore(key: string, open = false): Promise<void> {
  const restored = await api<{ id: string; name: string }>('POST', `${sequencePath(key)}/restore`);
  deletedByPage.delete(restored.id);
  notify('success', 'Restored', restored.name);
  await refreshSequences();
  await refreshDeleted();
  if (open && !state.sequence.peek()) actions.recordings.openSequence(restored.id);
}

export const renameSequence = (id: string, name: string): Promise<void> =>
  attempt('The recording was not renamed', async () => {
    await api('PATCH', sequencePath(id), { name });
    const info = state.sequence.peek();
    if (info?.id === id) state.sequence.value = { ...info, name };
    await refreshSequences();
  });

export const deleteSequence = (id: string): Promise<void> =>
  attempt('The recording was not deleted', () => remove(id));

/** Bring a deleted recording back, with its labels. */
export const restoreSequence = (identity: string): Promise<void> =>
  attempt('The recording was not restored', () => restore(identity));

/** Try again to bring in the labels in a recording's own files. */
export const importSourceLabels = (id: string): Promise<void> =>
  attempt('The labels were not imported', async () => {
    try {
      await api('POST', `${sequencePath(id)}/source-labels`);
    } finally {
      await refreshSequences();
    }
  });

export const recordingActions = {
  recordings: {
    refreshSequences: () => attempt('The list of recordings did not load', refreshSequences),
  },
  tracking: {
    cancelJob: (id, keep = false) =>
      attempt('The job could not be stopped', async () => {
        const query = keep ? '?keep=true' : '';
        noteJob(jobOf(await api<RestJob>('DELETE', `jobs/${id}${query}`)));
      }),
  },
} satisfies ActionParts;
