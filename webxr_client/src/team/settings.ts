/** Settings of a project for its managers: their state, and the requests that change them. */
import { computed, signal } from '@preact/signals';
import { loadCategories } from '../engine/labels/categories';
import { projectPath, projects, refreshProjects, settled } from '../engine/recordings/projects';
import { attempt, succeeds } from '../engine/recordings/recordings';
import { api } from '../net/rest';
import type {
  Category,
  Delivery,
  ProjectInfo,
  SecretWebhook,
  Task,
  Taxonomy,
  Webhook,
} from '../protocol/values';
import { actions } from '../store/actions';
import { loadTasks } from '../work/queue';

export const TABS = [
  ['people', 'People'],
  ['categories', 'Categories'],
  ['recordings', 'Recordings'],
  ['tasks', 'Tasks'],
  ['webhooks', 'Webhooks'],
] as const;
export type SettingsTab = (typeof TABS)[number][0];

/** Values of a project to set. */
type ProjectPatch = Partial<Pick<ProjectInfo, 'name' | 'roles' | 'categories' | 'recordings'>>;

export const settingsTab = signal<SettingsTab>('people');
export const settledProject = computed(
  () => projects.value.find(({ id }) => id === settled.value) ?? null,
);
/** The workspace's, by number. */
export const taxonomy = signal<readonly Category[]>([]);
export const projectTasks = signal<readonly Task[]>([]);
export const webhooks = signal<readonly Webhook[]>([]);
/** Latest events of each webhook, the newest first. */
export const deliveries = signal<ReadonlyMap<string, readonly Delivery[]>>(new Map());
/** The secret of the newest webhook, which the server sends once. */
export const secret = signal<{ readonly webhook: string; readonly words: string } | null>(null);

function place(rest = ''): string {
  return `${projectPath(settled.peek() ?? '')}${rest}`;
}

/** Changes of a project follow each other: each has all people, or all categories. */
let last: Promise<void> = Promise.resolve();
let saves = 0;

/** Change the project; show the change at once. */
export function save(patch: ProjectPatch): Promise<void> {
  const path = place();
  const { recordings, ...shown } = patch;
  projects.value = projects.peek().map((each) => each.id === settled.peek() ? { ...each, ...shown } : each); // prettier-ignore
  const turn = ++saves;
  last = last.then(async () => {
    await attempt('The project was not changed', () => api('PATCH', path, patch));
    // Later changes are shown already, and the server does not know of them yet.
    if (turn === saves) await refreshProjects();
    if (patch.categories !== undefined) await loadCategories();
    if (recordings) await actions.recordings.refreshSequences();
  });
  return last;
}

/** Give a person a role in the project, or (null) take them out of it. */
export function setRole(account: string, role: string | null): Promise<void> {
  const before = Object.entries(settledProject.peek()?.roles ?? {});
  const others = Object.fromEntries(before.filter(([name]) => name !== account));
  return save({
    roles: role === null ? others : { ...others, [account]: role as ProjectInfo['role'] },
  });
}

/** Select a category, or leave it out; all selected is no selection. */
export function selectCategory(number: number, on: boolean): Promise<void> {
  const all = taxonomy.peek().map((each) => each.number);
  const before = settledProject.peek()?.categories ?? all;
  const now = new Set(before);
  if (on) now.add(number);
  else now.delete(number);
  const whole = all.every((each) => now.has(each));
  return save({ categories: whole ? null : [...now].sort((a, b) => a - b) });
}

export const loadTaxonomy = (): Promise<void> =>
  attempt('The categories did not load', async () => {
    const found = await api<Taxonomy>('GET', 'taxonomy');
    taxonomy.value = found.categories;
  });

export const loadProjectTasks = (): Promise<void> =>
  attempt('The tasks did not load', async () => {
    projectTasks.value = await api<Task[]>('GET', place('/tasks?limit=10000'));
  });

export async function deleteTask({ number }: Task): Promise<void> {
  await attempt('The task was not deleted', () => api('DELETE', place(`/tasks/${number}`)));
  await Promise.all([loadProjectTasks(), loadTasks()]);
}

export const loadWebhooks = (): Promise<void> =>
  attempt('The webhooks did not load', async () => {
    const found = await api<Webhook[]>('GET', place('/webhooks'));
    const requests = found.map(({ id }) =>
      api<Delivery[]>('GET', place(`/webhooks/${id}/deliveries`)),
    );
    const events = await Promise.all(requests);
    deliveries.value = new Map(found.map(({ id }, k) => [id, events[k]!]));
    webhooks.value = found;
  });

/** Add a webhook; returns true if the server took it. */
export async function addWebhook(url: string, topics: readonly string[]): Promise<boolean> {
  const done = await succeeds('The webhook was not added', async () => {
    const body = { url, topics };
    const made = await api<SecretWebhook>('POST', place('/webhooks'), body);
    secret.value = { webhook: made.id, words: made.secret };
  });
  await loadWebhooks();
  return done;
}

export async function removeWebhook({ id }: Webhook): Promise<void> {
  await attempt('The webhook was not removed', () => api('DELETE', place(`/webhooks/${id}`)));
  await loadWebhooks();
}

export async function deleteProject(): Promise<void> {
  await attempt('The project was not deleted', async () => {
    await api('DELETE', place());
    settled.value = null;
  });
  await refreshProjects();
}
