/** Own imports that are under way together, until the card that shows them is closed. */
import { computed, signal } from '@preact/signals';
import type { Job } from '../../protocol/messages';
import { isActive, isMine, state } from '../../store/state';

const ids = signal<readonly string[]>([]);
/** Names of the recordings that imports begun on this page make, by job. */
const names = new Map<string, string>();

/** Jobs of these imports, in the order in which they were begun. */
export const ownImports = computed(() => {
  const known = new Map(state.jobs.value.map((job) => [job.id, job]));
  return ids.value.flatMap((id) => known.get(id) ?? []);
});

/** Begin a new group where none is under way, and add imports to it, by id and name. */
export function joinImports(added: readonly (readonly [id: string, name: string])[]): void {
  const others = ownImports.peek().some(isActive) ? ids.peek() : [];
  for (const [id, name] of added) names.set(id, name);
  ids.value = [...new Set([...others, ...added.map(([id]) => id)])];
}

export function closeImports(): void {
  ids.value = [];
}

/** Add an import that was started elsewhere, at its first message. */
export function noteImport(job: Job): void {
  const known = ids.peek().includes(job.id);
  if (job.kind === 'import' && isActive(job) && isMine(job) && !known) joinImports([[job.id, '']]);
}

/** Whether an import is one of several, which are shown together. */
export function isOneOfSeveral({ id }: Job): boolean {
  return ids.peek().length > 1 && ids.peek().includes(id);
}

/** Name of the recording that an import makes. */
export function importName({ id, sequence }: Job): string {
  const row = state.sequences.value?.find((each) => each.id === sequence);
  return row?.name ?? (names.get(id) || sequence) ?? 'a recording';
}
