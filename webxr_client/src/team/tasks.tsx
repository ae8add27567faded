/** The queue: one's own task, what is to be reviewed, and who has what. */
import { signal } from '@preact/signals';
import { type Project, TASK_STATES, TASK_WORDS } from '../engine/projects';
import { Icon } from '../common/icons';
import { plural } from '../common/format';
import { Button } from '../panels/parts/controls';
import type { Place } from '../reviewing/model';
import { Pin } from '../reviewing/pin';
import { ROLES, state } from '../store/state';
import { AccountHint } from '../panels/parts/account-hint';
import {
  addTasks,
  begin,
  change,
  chosen,
  goToTask,
  judged,
  mine,
  nextTask,
  project,
  sendBack,
  type Task,
  tasks,
  taskWords,
} from './store';

export const may = ({ role }: Project, least: Project['role']): boolean =>
  ROLES.indexOf(role) >= ROLES.indexOf(least);

export function Tasks() {
  const of = project.value;
  if (!of) return <p class="soft empty">Loading the tasks…</p>;
  return (
    <>
      {may(of, 'annotator') && <Own />}
      {may(of, 'reviewer') && <Judge of={of} />}
      <ByPerson />
      {may(of, 'manager') && <Make />}
    </>
  );
}

function Own() {
  const [task, ...others] = mine.value;
  return (
    <section class="own-tasks" aria-label="My task">
      <h3>My task</h3>
      {task ? <Told task={task} /> : <p class="soft">No task started.</p>}
      <div class="group">
        <Button
          label={task?.state === 'taken' ? 'Hand in, next task' : 'Next task'}
          kind="primary"
          keys="Shift N"
          tip="Hand in the task of this recording and open the next task"
          onClick={() => void nextTask()}
        />
        {task?.state === 'taken' && (
          <Button
            label="Give back"
            kind="outlined"
            tip="Return the task to the queue for another annotator"
            onClick={() => void change(task, { state: 'open' })}
          />
        )}
      </div>
      {others.length > 0 && <List entries={others} />}
    </section>
  );
}

/** A task in full: a click goes to its note's place, or to its first frame. */
function Told({ task }: { task: Task }) {
  return (
    <>
      <List entries={[task]} />
      {task.note && (
        <Button
          icon="target"
          label={task.place ? `Go to the place in frame ${task.frame}` : 'Go to the task'}
          kind="outlined"
          small
          onClick={() => goToTask(task)}
        />
      )}
    </>
  );
}

function List({ entries }: { entries: readonly Task[] }) {
  return (
    <ul class="findings">
      {entries.map((task) => (
        <li key={task.number} data-current={task.number === chosen.value || undefined}>
          <button type="button" class="menu-item" onClick={() => goToTask(task)}>
            <Icon name={task.place ? 'target' : 'frames'} />
            <span class="what">
              {taskWords(task)}
              <span class="soft">
                <strong class="task-state" data-state={task.state}>
                  {TASK_WORDS[task.state]}
                </strong>
                {task.reviewer && ` · ${task.reviewer}`}
              </span>
              {task.note && <q>{task.note}</q>}
            </span>
          </button>
        </li>
      ))}
    </ul>
  );
}

const draft = signal<{ note: string; place: Place | null }>({ note: '', place: null });

function Judge({ of }: { of: Project }) {
  const task = judged.value;
  return (
    <section class="own-tasks" aria-label="To review">
      <h3>To review</h3>
      <Button label="Next to review" kind="outlined" onClick={() => void begin(of.id, 'review')} />
      {task && ['done', 'review', 'accepted'].includes(task.state) && <Verdict task={task} />}
    </section>
  );
}

function Verdict({ task }: { task: Task }) {
  const { note, place } = draft.value;
  const back = async (): Promise<void> => {
    if (await sendBack(task, note.trim(), place)) draft.value = { note: '', place: null };
  };
  return (
    <form class="review-form" aria-label="Verdict" onSubmit={(event) => event.preventDefault()}>
      <p>
        {taskWords(task)}, by <strong>{task.assignee || 'no annotator'}</strong>
      </p>
      <label>
        Note
        <textarea
          rows={2}
          maxLength={2000}
          value={note}
          placeholder="Describe the correction"
          onInput={({ currentTarget }) => (draft.value = { ...draft.peek(), note: currentTarget.value })}
          onKeyDown={(event) => event.stopPropagation()}
        />
      </label>
      <Pin place={place} onPin={(at) => (draft.value = { ...draft.peek(), place: at })} />
      <div class="verdicts">
        <Button
          class="verdict-accepted"
          label="Accept"
          kind="outlined"
          disabled={task.state === 'accepted'}
          onClick={() => void change(task, { state: 'accepted' })}
        />
        <Button
          class="verdict-rejected"
          label="Send back"
          kind="outlined"
          tip="Pin the note to the chosen place or to the centre of the view"
          disabled={!note.trim()}
          onClick={() => void back()}
        />
      </div>
    </form>
  ); // prettier-ignore
}

/** Everybody's tasks, those of nobody first. */
function ByPerson() {
  const people = [...new Set(tasks.value.map(({ assignee }) => assignee))].sort();
  if (people.length === 0) return <p class="soft empty">This project has no tasks.</p>;
  return (
    <section class="own-tasks" aria-label="Tasks by person">
      <h3>Tasks by person</h3>
      {people.map((person) => {
        const theirs = tasks.value.filter(({ assignee }) => assignee === person);
        const told = TASK_STATES.map((kind) => [kind, theirs.filter((task) => task.state === kind).length] as const).filter(([, count]) => count > 0); // prettier-ignore
        return (
          <details key={person} open={people.length <= 4}>
            <summary>
              <strong>{person || 'Unassigned'}</strong>{' '}
              <span class="soft">
                {told.map(([kind, count]) => `${count} ${TASK_WORDS[kind]}`).join(', ')}
              </span>
            </summary>
            <List entries={theirs} />
          </details>
        );
      })}
    </section>
  );
}

const wanted = signal({ every: '', assignee: '', people: 1, all: false });

/** Makes tasks of the open recording, or of all of the project. */
function Make() {
  const { every, assignee, people, all } = wanted.value;
  const set = (patch: Partial<typeof wanted.value>): void => {
    wanted.value = { ...wanted.peek(), ...patch };
  };
  const submit = (event: Event): void => {
    event.preventDefault();
    const id = state.sequence.peek()!.id;
    void addTasks({ recordings: all ? null : [id], every: Number(every) || null, assignee, people });
  }; // prettier-ignore
  const count = project.value?.recordings.length ?? 0;
  return (
    <details class="make-tasks">
      <summary>Make tasks</summary>
      <form class="review-form" onSubmit={submit}>
        <label>
          Recordings
          <select
            value={all ? 'all' : ''}
            onChange={(event) => set({ all: event.currentTarget.value === 'all' })}
          >
            <option value="">this recording</option>
            <option value="all">all {plural(count, 'recording')} of the project</option>
          </select>
        </label>
        <label>
          Frames per task
          <input
            type="number"
            min={1}
            value={every}
            placeholder="all"
            onInput={(event) => set({ every: event.currentTarget.value })}
          />
        </label>
        <label>
          Assignee
          <input
            type="text"
            maxLength={128}
            placeholder="first free annotator"
            list="queue-people"
            value={assignee}
            onInput={(event) => set({ assignee: event.currentTarget.value.trim() })}
          />
        </label>
        <AccountHint id="queue-people" name={assignee} />
        <label>
          Annotators per task
          <input
            type="number"
            min={1}
            max={9}
            value={people}
            onInput={(event) => set({ people: Number(event.currentTarget.value) || 1 })}
          />
        </label>
        <button type="submit" class="button primary">
          Make tasks
        </button>
      </form>
    </details>
  );
}
