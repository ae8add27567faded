/** Projects: recordings in groups, what has been done of each, and the search in all of them. */
import { signal } from '@preact/signals';
import { api } from '../net/rest';
import type { SequenceOut } from '../net/early';
import type { Job, Welcome } from '../protocol/messages';
import { ROLES, state, type SequenceSummary } from '../store/state';
import { attempt, jobOf, noteJob, rowOf } from './recordings';

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

export interface Project {
  readonly id: string;
  readonly name: string;
  /** The caller's in it. */
  readonly role: Welcome['role'];
  readonly roles: Readonly<Record<string, string>>;
  /** Numbers of those that are selected; null: all. */
  readonly categories: readonly number[] | null;
  readonly recordings: readonly string[];
  readonly tasks: Counts;
  /** Tasks by person and state. */
  readonly people: Readonly<Record<string, Counts>>;
}

/** Figures of a project; hours are those that edits took. */
export interface Statistics {
  readonly points: number;
  readonly objects: number;
  readonly hours: number;
  readonly classes: readonly Figures[];
  readonly people: readonly { readonly name: string; readonly hours: number }[];
}

interface Figures {
  readonly name: string;
  readonly points: number;
  readonly objects: number;
  readonly hours: number;
}

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
export const projects = signal<readonly Project[]>([]);
/** Id of the project whose settings are open, or null. */
export const settled = signal<string | null>(null);
/** Project that imports go into. */
export const importInto = signal(FIRST);

export const refreshProjects = (): Promise<void> =>
  attempt('The projects did not load', async () => {
    projects.value = await api<Project[]>('GET', 'projects');
  });

export function projectPath(id: string): string {
  return `projects/${encodeURIComponent(id)}`;
}

/** The project of the open recording, or null. */
export function openProject(): Project | null {
  const id = rowOf(state.sequence.value?.id)?.project;
  return projects.value.find((project) => project.id === id) ?? null;
}

/** True if the caller's role in a project includes another one. */
export function may(of: Project | null, least: Project['role']): boolean {
  return of !== null && ROLES.indexOf(of.role) >= ROLES.indexOf(least);
}

export interface Group {
  readonly project: Pick<Project, 'id' | 'name'> & Partial<Project>;
  readonly rows: readonly SequenceSummary[];
}

/** Recordings by project, those of projects that are not known under their ids. */
export function grouped(
  rows: readonly SequenceSummary[],
  known: readonly Project[],
): readonly Group[] {
  const ids = new Set([...known.map(({ id }) => id), ...rows.map(({ project }) => project)]);
  return [...ids].map((id) => ({
    project: known.find((project) => project.id === id) ?? { id, name: id },
    rows: rows.filter(({ project }) => project === id),
  }));
}

/** Number of all tasks, and of those in one state. */
export function tasksOf(counts: Counts, kind?: TaskState): number {
  if (kind) return counts[kind] ?? 0;
  return Object.values(counts).reduce((sum, count) => sum + count, 0);
}

/** Ids of the recordings that meet all conditions; null where there are none to meet. */
export async function search(conditions: Conditions): Promise<ReadonlySet<string> | null> {
  const query = new URLSearchParams();
  for (const name of Object.keys(NO_CONDITIONS) as (keyof Conditions)[]) {
    const value = conditions[name].trim();
    if (value) query.set(name, value);
  }
  if (query.size === 0) return null;
  const found = await api<SequenceOut[]>('GET', `sequences?${query.toString()}`);
  return new Set(found.map(({ id }) => id));
}

export async function createProject(name: string): Promise<void> {
  await attempt('The project was not made', async () => {
    const { id } = await api<Project>('POST', 'projects', { name });
    importInto.value = id;
  });
  await refreshProjects();
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

/** Import each file or folder in a folder of the server as a recording of a project. */
export const importEach = (path: string, project: string): Promise<void> =>
  attempt('The import did not start', async () => {
    type Answer = Parameters<typeof jobOf>[0];
    const jobs: Job[] = (
      await api<Answer[]>('POST', `${projectPath(project)}/imports`, { path })
    ).map(jobOf);
    jobs.forEach(noteJob);
  });
