/** Tasks of the open recording's project, and the requests that change them; no panel is needed. */
import { computed, signal } from '@preact/signals';
import { projectPath, refreshProjects } from '../engine/recordings/projects';
import { attempt, rowOf, sequencePath, succeeds } from '../engine/recordings/recordings';
import { api } from '../net/rest';
import type { NewTasks, PastEdit, Task, TaskEvent, TaskPatch } from '../protocol/values';
import { actions } from '../store/actions';
import { notify, state } from '../store/state';
import { framesOf, type Place } from './model';
import { goTo, looking } from './places';
import { project } from './store';

export const tasks = signal<readonly Task[]>([]);
/** Number of the opened task. */
export const chosen = signal<number | null>(null);

/** The server identifies people by their names, not by their accounts. */
const me = (): string => state.me.value?.author ?? '';

/** Own tasks to do: the task that was begun, then returned tasks. */
export const mine = computed(() =>
  tasks.value
    .filter((task) => task.assignee === me() && ['taken', 'returned'].includes(task.state))
    .sort((a, b) => Number(b.state === 'taken') - Number(a.state === 'taken')),
);

/** The opened task of another person that can be accepted or returned, or null. */
export const judged = computed(() => {
  const task = tasks.value.find(({ number }) => number === chosen.value);
  const judges = task && task.assignee !== me() && ['done', 'review', 'accepted'].includes(task.state); // prettier-ignore
  return judges ? task : null;
});

/** Load the projects and the tasks of this one. */
export async function loadTasks(): Promise<void> {
  await Promise.all([actions.recordings.refreshSequences(), refreshProjects()]);
  const of = project.peek();
  await attempt('The tasks did not load', async () => {
    tasks.value = of ? await api<Task[]>('GET', `${projectPath(of.id)}/tasks?limit=10000`) : [];
  });
}

/** Take in a task as the server has it. */
function note(task: Task): void {
  const others = tasks.peek().filter(({ number }) => number !== task.number);
  tasks.value = [...others, task].sort((a, b) => a.number - b.number);
}

export function goToTask(task: Task): void {
  chosen.value = task.number;
  goTo(task.sequence, task.frame ?? task.first, task.place);
}

export function taskWords(task: Task): string {
  return `${rowOf(task.sequence)?.name ?? task.sequence}, ${framesOf(task)}`;
}

const taskPath = ({ number }: Task): string =>
  `${projectPath(project.peek()?.id ?? '')}/tasks/${number}`;

/** Change a task; returns true if the server took it. */
const change = (task: Task, patch: TaskPatch): Promise<boolean> =>
  succeeds('The task was not changed', async () => {
    note(await api<Task>('PATCH', taskPath(task), patch));
  });

/** Take the next task of a project, to label or to review, and go to it. */
export async function begin(of: string, work: 'label' | 'review' = 'label'): Promise<void> {
  chosen.value = null;
  await attempt('There is no next task', async () => {
    const task = await api<Task | null>('POST', `${projectPath(of)}/tasks/next`, { work });
    if (task) {
      note(task);
      goToTask(task);
    } else notify('info', `No task is left to ${work}`, 'All tasks are done or taken.');
  });
  await loadTasks();
}

/** Return true if this person has not edited the task since they got it, first or once more. */
async function isUnchanged(task: Task): Promise<boolean> {
  if (state.pending.peek() > 0) return false;
  const [edits, events] = await Promise.all([
    api<PastEdit[]>('GET', `${sequencePath(task.sequence)}/edits?limit=1000`),
    api<TaskEvent[]>('GET', `${taskPath(task)}/history`),
  ]);
  const got = events.find((event) => event.state === 'open' || event.state === 'returned');
  const since = got ? Date.parse(got.at) : 0;
  const own = edits.filter(({ author, undone }) => author === me() && !undone);
  return !own.some(
    ({ kind, time, frames }) =>
      kind !== 'undo' && Date.parse(time) >= since && frames.some((frame) => task.first <= frame && frame <= task.last), // prettier-ignore
  );
}

/** A task without a change waits to be handed in: `answer` hands it in (true) or keeps it. */
interface Question {
  readonly task: Task;
  readonly answer: (yes: boolean) => void;
}

/** The question that the desk or the headset asks; null: none. */
export const question = signal<Question | null>(null);

function confirmed(task: Task): Promise<boolean> {
  return new Promise((resolve) => {
    const answer = (yes: boolean): void => {
      question.value = null;
      resolve(yes);
    };
    question.value = { task, answer };
  });
}

/** Hand in an own task, after a question if it has no change; returns true if it was. */
export async function handIn(task: Task): Promise<boolean> {
  // If the server does not answer, the change fails and names the reason.
  const unchanged = await isUnchanged(task).catch(() => false);
  if (unchanged && !(await confirmed(task))) return false;
  if (!(await change(task, { state: 'done' }))) return false;
  const run = (): void => void change(task, { state: 'taken' }).then(() => goToTask(task));
  notify('success', `Handed in: ${taskWords(task)}`, '', { label: 'Take back', run });
  return true;
}

/** Submit the own task of the open recording, if any, and go to the next task. */
export async function nextTask(): Promise<void> {
  await loadTasks();
  const of = project.peek();
  if (!of) return;
  const open = state.sequence.peek()?.id;
  const own = mine.peek().find((task) => task.state === 'taken' && task.sequence === open);
  if (!own || (await handIn(own))) await begin(of.id);
}

/** Take the next task of the open project that waits for a review. */
export async function nextReview(): Promise<void> {
  if (!project.peek()) await loadTasks();
  const of = project.peek();
  if (of) await begin(of.id, 'review');
}

export const accept = (task: Task): Promise<boolean> => change(task, { state: 'accepted' });

/** Put an own task back into the queue, for another annotator. */
export const release = (task: Task): Promise<boolean> => change(task, { state: 'open' });

/** Return a task with a note, at the place given or at the one in the middle of the picture. */
export function giveBack(task: Task, note: string, pinned: Place | null): Promise<boolean> {
  const frame = state.frame.peek();
  const isOpen = state.sequence.peek()?.id === task.sequence;
  const place = pinned ?? looking.at();
  const within = isOpen && task.first <= frame && frame <= task.last;
  const pin = place && within ? { frame, place } : {};
  return change(task, { state: 'returned', note, ...pin });
}

/** Make tasks of a project; returns true if the server did. */
export async function addTasks(wanted: NewTasks, of = project.peek()?.id ?? ''): Promise<boolean> {
  const done = await succeeds('The tasks were not made', () =>
    api('POST', `${projectPath(of)}/tasks`, { ...wanted, id: crypto.randomUUID() }),
  );
  await loadTasks();
  return done;
}
