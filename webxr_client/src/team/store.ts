/** Tasks and snapshots of the open recording's project, and the requests that change them. */
import { computed, signal } from '@preact/signals';
import { openProject, projectPath, refreshProjects, type TaskState } from '../engine/projects';
import { attempt, rowOf } from '../engine/recordings';
import { api } from '../net/rest';
import type { Place } from '../reviewing/model';
import { looking, reviewOpen, visit } from '../reviewing/store';
import { actions } from '../store/actions';
import { notify, state } from '../store/state';
import { follow } from '../store/watch';

/** Frames `first` to `last` of a recording, both included. */
export interface Task {
  readonly number: number;
  readonly sequence: string;
  readonly first: number;
  readonly last: number;
  readonly state: TaskState;
  readonly assignee: string;
  readonly reviewer: string;
  readonly note: string;
  /** Frame and point that the note is pinned to. */
  readonly frame: number | null;
  readonly place: Place | null;
}

/** Values of a task to set. */
interface TaskPatch {
  readonly state?: TaskState;
  readonly assignee?: string;
  readonly note?: string;
  readonly frame?: number;
  readonly place?: Place;
}

export type TeamTab = 'tasks' | 'agreement' | 'versions';

export const teamOpen = signal(false);
export const teamTab = signal<TeamTab>('tasks');
export const tasks = signal<readonly Task[]>([]);
/** Number of the task that one looks at. */
export const chosen = signal<number | null>(null);
export const project = computed(openProject);

const me = (): string => state.me.value?.account ?? '';

/** Own tasks to be done: the one that was begun, then those returned. */
export const mine = computed(() =>
  tasks.value
    .filter((task) => task.assignee === me() && ['taken', 'returned'].includes(task.state))
    .sort((a, b) => Number(b.state === 'taken') - Number(a.state === 'taken')),
);

/** The task of somebody else that one looks at, or null. */
export const judged = computed(
  () => tasks.value.find(({ number, assignee }) => number === chosen.value && assignee !== me()) ?? null, // prettier-ignore
);

/** Others work meanwhile, and nobody tells of it. */
const AGAIN_MS = 20_000;

/** Fetch projects and tasks, quietly where it is only to see what others did. */
export async function refresh(): Promise<void> {
  await Promise.all([actions.refreshSequences(), refreshProjects()]);
  const of = project.peek();
  await attempt('The tasks did not load', async () => {
    tasks.value = of ? await api<Task[]>('GET', `${projectPath(of.id)}/tasks?limit=10000`) : [];
  });
}

/** Take in what the server says of a task. */
function note(task: Task): void {
  const others = tasks.peek().filter(({ number }) => number !== task.number);
  tasks.value = [...others, task].sort((a, b) => a.number - b.number);
}

/** Open the panel, which takes the place of the review. */
export function openTeam(tab: TeamTab = teamTab.peek()): void {
  reviewOpen.value = false;
  teamTab.value = tab;
  teamOpen.value = true;
}

interface Goal {
  readonly sequence: string;
  readonly frame: number;
  readonly place: Place | null;
}

/** A place to go to once its recording is open. */
const goal = signal<Goal | null>(null);

/** Go to a frame of a recording, which is opened first, and fly to the place in it. */
export function goTo(sequence: string, frame: number, place: Place | null = null): void {
  goal.value = { sequence, frame, place };
  if (state.sequence.peek()?.id !== sequence) actions.openSequence(sequence);
}

/** A flight before the view is chosen would be undone. */
function arrive(): void {
  const { value } = goal;
  const here = value && state.opening.value === null && state.sequence.value?.id === value.sequence;
  if (!here || !state.framed.value) return;
  queueMicrotask(() => {
    if (goal.peek() !== value || !state.framed.peek()) return;
    goal.value = null;
    visit(value.frame, value.place);
  });
}

export function goToTask(task: Task): void {
  chosen.value = task.number;
  goTo(task.sequence, task.frame ?? task.first, task.place);
}

export function taskWords({ sequence, first, last }: Task): string {
  const name = rowOf(sequence)?.name ?? sequence;
  return `${name}, ${first === last ? `frame ${first}` : `frames ${first}–${last}`}`;
}

/** Change a task; tells whether the server took it. */
export async function change(task: Task, patch: TaskPatch): Promise<boolean> {
  const of = project.peek();
  let done = false;
  await attempt('The task was not changed', async () => {
    const path = `${projectPath(of!.id)}/tasks/${task.number}`;
    const next = await api<Task>('PATCH', path, patch);
    note(next);
    done = true;
  });
  return done;
}

/** Take the next task of a project, to label or to review, and go to it. */
export async function begin(of: string, work: 'label' | 'review' = 'label'): Promise<void> {
  await attempt('There is no next task', async () => {
    const task = await api<Task | null>('POST', `${projectPath(of)}/tasks/next`, { work });
    if (task) {
      note(task);
      openTeam('tasks');
      goToTask(task);
    } else {
      const what = work === 'label' ? 'label' : 'review';
      notify('info', `No task is left to ${what}`, 'All tasks are done or taken.');
    }
  });
  await refresh();
}

/** Hand in the own task whose recording is open, if there is one, and go on to the next. */
export async function nextTask(): Promise<void> {
  if (!project.peek()) await refresh();
  const of = project.peek();
  if (!of) return;
  const open = state.sequence.peek()?.id;
  const own = mine.peek().find(({ state: kind, sequence }) => kind === 'taken' && sequence === open); // prettier-ignore
  if (own) {
    if (!(await change(own, { state: 'done' }))) return;
    const run = (): void => void change(own, { state: 'taken' }).then(() => goToTask(own));
    notify('success', `Handed in: ${taskWords(own)}`, '', { label: 'Take back', run });
  }
  await begin(of.id);
}

/** Send a task back, pinned to the place given, or to the one in the middle of the picture. */
export async function sendBack(task: Task, note: string, pinned: Place | null): Promise<boolean> {
  const frame = state.frame.peek();
  const here = state.sequence.peek()?.id === task.sequence;
  const place = pinned ?? looking.at();
  const within = here && task.first <= frame && frame <= task.last;
  const pin = place && within ? { frame, place } : {};
  return change(task, { state: 'returned', note, ...pin });
}

export interface NewTasks {
  readonly recordings: readonly string[] | null;
  readonly every: number | null;
  readonly assignee?: string;
  readonly people?: number;
  /** Labels that are there are right, and hidden from who labels. */
  readonly truth?: boolean;
}

/** Make tasks of a project; tells whether the server did. */
export async function addTasks(wanted: NewTasks, of = project.peek()?.id ?? ''): Promise<boolean> {
  let done = false;
  await attempt('The tasks were not made', async () => {
    await api('POST', `${projectPath(of)}/tasks`, { ...wanted, id: crypto.randomUUID() });
    done = true;
  });
  await refresh();
  return done;
}

/** Keep up with the open recording and with others; the result ends it. */
export function followTeam(): () => void {
  const stops = [
    follow(arrive),
    follow(() => {
      if (reviewOpen.value) teamOpen.value = false;
    }),
    follow(() => {
      if (teamOpen.value && state.sequence.value) queueMicrotask(() => void refresh());
    }),
  ];
  const again = setInterval(() => {
    if (teamOpen.peek() && state.sequence.peek() && !document.hidden) void refresh();
  }, AGAIN_MS);
  return () => {
    clearInterval(again);
    for (const stop of stops) stop();
  };
}
