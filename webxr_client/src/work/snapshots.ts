/** Snapshots of the open recording's project, and the difference of two. */
import { signal } from '@preact/signals';
import { projectPath } from '../engine/recordings/projects';
import { attempt, succeeds } from '../engine/recordings/recordings';
import { api } from '../net/rest';
import type { Difference, Snapshot } from '../protocol/values';
import { project } from './store';

export const KIND_WORDS: Readonly<Record<string, string>> = {
  came: 'new',
  went: 'gone',
  changed: 'renamed or recoloured',
};

export const snapshots = signal<readonly Snapshot[]>([]);
/** The snapshot that is compared. */
export const compared = signal<Snapshot | null>(null);
/** With another snapshot's id, or "" for the labels of now; null until the server has answered. */
export const difference = signal<{
  readonly with: string;
  readonly found: readonly Difference[];
} | null>(null);

/** Answers to earlier questions are of no interest. */
let newestRequest = 0;

function path(rest = ''): string {
  return `${projectPath(project.peek()?.id ?? '')}/snapshots${rest}`;
}

export async function loadSnapshots(): Promise<void> {
  compared.value = difference.value = null;
  if (!project.peek()) return;
  await attempt('The snapshots did not load', async () => {
    snapshots.value = await api<Snapshot[]>('GET', path());
  });
}

/** Name the current labels of the project; returns true if the server did. */
export const createSnapshot = (name: string): Promise<boolean> =>
  succeeds('The snapshot was not made', async () => {
    const made = await api<Snapshot>('POST', path(), { name });
    snapshots.value = [made, ...snapshots.peek()];
  });

/** Find the difference of a snapshot and another one, or ("") the labels of now. */
export async function compare(snapshot: Snapshot, other = ''): Promise<void> {
  const turn = ++newestRequest;
  compared.value = snapshot;
  difference.value = null;
  await attempt('The snapshots were not compared', async () => {
    const query = other ? `?with=${encodeURIComponent(other)}` : '';
    const rest = `/${encodeURIComponent(snapshot.id)}/difference${query}`;
    const found = await api<Difference[]>('GET', path(rest));
    if (turn === newestRequest) difference.value = { with: other, found };
  });
}

export async function removeSnapshot(snapshot: Snapshot): Promise<void> {
  await attempt('The snapshot was not deleted', async () => {
    await api('DELETE', path(`/${encodeURIComponent(snapshot.id)}`));
    await loadSnapshots();
  });
}
