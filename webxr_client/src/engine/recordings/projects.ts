/** Projects: recordings in groups, their progress, and the search in all of them. */
import { signal } from '@preact/signals';
import { api } from '../../net/rest';
import { actions } from '../../store/actions';
import type { Manifest, ProjectInfo } from '../../protocol/values';
import { ROLES, state, type SequenceSummary } from '../../store/state';
import { attempt, rowOf } from './recordings';

export const TASK_STATES = ['open', 'taken', 'done', 'review', 'returned', 'accepted'] as const;
export type TaskState = (typeof TASK_STATES)[number];
export type Counts = Readonly<Partial<Record<TaskState, number>>>;

export const TASK_WORDS: Readonly<Record<TaskState, string>> = {
  open: 'open',
  taken: 'begun',
  done: 'handed in',
  review: 'in review',
  returned: 'returned',
  accepted: 'accepted',
};

/** Conditions of a search, by the names of the server's query; "" is none. */
export interface Conditions {
  readonly class: string;
  readonly label: string;
  readonly person: string;
  readonly state: string;
}

export const NO_CONDITIONS: Conditions = { class: '', label: '', person: '', state: '' };
export const FIRST = 'default';

/** By name; empty until the server has answered. */
export const projects = signal<readonly ProjectInfo[]>([]);
/** Id of the project with open settings, or null. */
export const settled = signal<string | null>(null);
/** ProjectInfo that imports go into. */
export const importInto = signal(FIRST);

export const refreshProjects = (): Promise<void> =>
  attempt('The projects did not load', async () => {
    projects.value = await api<ProjectInfo[]>('GET', 'projects');
  });

export function projectPath(id: string): string {
  return `projects/${encodeURIComponent(id)}`;
}

/** The project of the open recording, or null. */
export function openProject(): ProjectInfo | null {
  const id = rowOf(state.sequence.value?.id)?.project;
  return projects.value.find((project) => project.id === id) ?? null;
}

/** True if the caller's role in a project includes another one. */
export function may(of: ProjectInfo | null, least: ProjectInfo['role']): boolean {
  return of !== null && ROLES.indexOf(of.role) >= ROLES.indexOf(least);
}

export interface Group {
  readonly project: Pick<ProjectInfo, 'id' | 'name'> & Partial<ProjectInfo>;
  readonly rows: readonly SequenceSummary[];
}

/** Return recordings by project; unknown projects are named by their ids. */
export function grouped(
  rows: readonly SequenceSummary[],
  known: readonly ProjectInfo[],
): readonly Group[] {
  const found = new Map<string, SequenceSummary[]>(known.map(({ id }) => [id, []]));
  for (const row of rows) {
    const own = found.get(row.project);
    if (own) own.push(row);
    else found.set(row.project, [row]);
  }
  const named = new Map(known.map((project) => [project.id, project]));
  return [...found].map(([id, own]) => ({ project: named.get(id) ?? { id, name: id }, rows: own }));
}

/** Return the number of all tasks, or of tasks in one state. */
export function tasksOf(counts: Counts, kind?: TaskState): number {
  if (kind) return counts[kind] ?? 0;
  return Object.values(counts).reduce((sum, count) => sum + count, 0);
}

/** Return the ids of the recordings that meet all conditions; null without conditions. */
export async function search(conditions: Conditions): Promise<ReadonlySet<string> | null> {
  const query = new URLSearchParams();
  for (const name of Object.keys(NO_CONDITIONS) as (keyof Conditions)[]) {
    const value = conditions[name].trim();
    if (value) query.set(name, value);
  }
  if (query.size === 0) return null;
  const found = await api<Manifest[]>('GET', `sequences?${query.toString()}`);
  return new Set(found.map(({ id }) => id));
}

/** Create a project with recordings of others; returns its id, or null where that failed. */
export async function createProject(
  name: string,
  recordings: readonly string[],
): Promise<string | null> {
  let made: string | null = null;
  await attempt('The project was not made', async () => {
    made = (await api<ProjectInfo>('POST', 'projects', { name, recordings })).id;
    importInto.value = made;
  });
  await Promise.all([
    refreshProjects(),
    recordings.length > 0 && actions.recordings.refreshSequences(),
  ]);
  return made;
}

/** The first project with a task for an account to label, and the first with one to review. */
export function nextWork(
  known: readonly ProjectInfo[],
  account: string,
): { readonly label: ProjectInfo | undefined; readonly review: ProjectInfo | undefined } {
  const own = ({ people }: ProjectInfo): Counts => people[account] ?? {};
  const free = ({ people }: ProjectInfo): number => people['']?.open ?? 0;
  const begun = ({ taken = 0, returned = 0, open = 0 }: Counts): number => taken + returned + open;
  const judged = (counts: Counts): number => (counts.done ?? 0) + (counts.review ?? 0);
  return {
    label:
      known.find((each) => may(each, 'annotator') && begun(own(each)) > 0) ??
      known.find((each) => may(each, 'annotator') && free(each) > 0),
    review: known.find((each) => may(each, 'reviewer') && judged(each.tasks) > judged(own(each))),
  };
}

/** Put a recording into another project. */
export async function moveRecording(recording: string, project: string): Promise<void> {
  await attempt('The recording was not moved', async () => {
    await api('PATCH', projectPath(project), { recordings: [recording] });
    const rows = state.sequences.peek() ?? [];
    state.sequences.value = rows.map((row) => (row.id === recording ? { ...row, project } : row));
  });
  await refreshProjects();
}
