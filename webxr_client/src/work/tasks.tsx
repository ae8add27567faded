/** The queue: the own task, the one to review, and the tasks of each person. */
import type { Task } from '../protocol/values';
import { signal } from '@preact/signals';
import { may, TASK_STATES, TASK_WORDS, type TaskState } from '../engine/recordings/projects';
import { Button } from '../panels/parts/controls';
import { state } from '../store/state';
import { MakeTasks } from './make-tasks';
import type { Place } from './model';
import { Entry, NoteField } from './parts';
import * as queue from './queue';
import { project } from './store';

/** With more people, their lists begin closed. */
const OPENED = 4;

export function Tasks() {
  const of = project.value;
  if (!of) return <p class="soft empty">Loading the tasks…</p>;
  return (
    <>
      {may(of, 'annotator') && <Own />}
      {may(of, 'reviewer') && <ToReview />}
      <ByPerson />
      {may(of, 'manager') && (
        <details>
          <summary>Make tasks</summary>
          <MakeTasks key={state.sequence.value?.id} of={of} open={state.sequence.value} />
        </details>
      )}
    </>
  );
}

function Own() {
  const [task, ...others] = queue.mine.value;
  const begun = task?.state === 'taken';
  return (
    <section class="stack" aria-label="My task">
      <h3>My task</h3>
      {task ? <List entries={[task]} /> : <p class="soft">No task started.</p>}
      <div class="line wrap">
        <Button
          label={begun ? 'Hand in, next task' : 'Next task'}
          kind={queue.tasks.value.length > 0 ? 'primary' : 'outlined'}
          keys="Shift N"
          tip="Hand in the task of this recording and open the next task"
          onClick={() => void queue.nextTask()}
        />
        {begun && (
          <Button
            label="Release"
            kind="outlined"
            tip="Put the task back into the queue for another annotator"
            onClick={() => void queue.release(task)}
          />
        )}
      </div>
      {others.length > 0 && <List entries={others} />}
    </section>
  );
}

function List({ entries }: { entries: readonly Task[] }) {
  return (
    <ul class="entries">
      {entries.map((task) => (
        <Entry
          key={task.number}
          icon={task.place ? 'target' : 'frames'}
          current={task.number === queue.chosen.value}
          about={<About task={task} />}
          onClick={() => queue.goToTask(task)}
        >
          {queue.taskWords(task)}
        </Entry>
      ))}
    </ul>
  );
}

function About({ task: { state: kind, reviewer, note } }: { task: Task }) {
  return (
    <>
      <strong class="of-state" data-state={kind}>
        {TASK_WORDS[kind]}
      </strong>
      {reviewer && ` · ${reviewer}`}
      {note && <q>{note}</q>}
    </>
  );
}

function ToReview() {
  return (
    <section class="stack" aria-label="To review">
      <h3>To review</h3>
      {queue.judged.value && <Verdict task={queue.judged.value} />}
      <div class="line wrap">
        <Button label="Next to review" kind="outlined" onClick={() => void queue.nextReview()} />
      </div>
    </section>
  );
}

const EMPTY: { note: string; place: Place | null } = { note: '', place: null };
const draft = signal(EMPTY);

function Verdict({ task }: { task: Task }) {
  const { note, place } = draft.value;
  const back = async (): Promise<void> => {
    if (await queue.giveBack(task, note.trim(), place)) draft.value = EMPTY;
  };
  return (
    <form class="work-form stack" aria-label="Verdict" onSubmit={(event) => event.preventDefault()}>
      <p>
        {queue.taskWords(task)}, by <strong>{task.assignee || 'no annotator'}</strong>
      </p>
      <NoteField
        note={note}
        place={place}
        onChange={(patch) => (draft.value = { ...draft.peek(), ...patch })}
      />
      <div class="halves">
        <Button
          class="verdict-accepted"
          label="Accept"
          kind="outlined"
          disabled={task.state === 'accepted'}
          onClick={() => void queue.accept(task)}
        />
        <Button
          class="verdict-rejected"
          label="Return"
          kind="outlined"
          tip="Pin the note to the chosen place or to the centre of the view"
          disabled={!note.trim()}
          onClick={() => void back()}
        />
      </div>
    </form>
  );
}

/** The tasks of each person, tasks without an assignee first. */
function ByPerson() {
  const people = [...new Set(queue.tasks.value.map(({ assignee }) => assignee))].sort();
  if (people.length === 0) return <p class="soft empty">This project has no tasks.</p>;
  return (
    <section class="stack" aria-label="Tasks by person">
      <h3>Tasks by person</h3>
      {people.map((person) => {
        const own = queue.tasks.value.filter(({ assignee }) => assignee === person);
        return (
          <details key={person} open={people.length <= OPENED}>
            <summary>
              <strong>{person || 'Unassigned'}</strong> <span class="soft">{countWords(own)}</span>
            </summary>
            <List entries={own} />
          </details>
        );
      })}
    </section>
  );
}

function countWords(tasks: readonly Task[]): string {
  const count = (kind: TaskState) => tasks.filter((task) => task.state === kind).length;
  const kinds = TASK_STATES.filter((kind) => count(kind) > 0);
  return kinds.map((kind) => `${count(kind)} ${TASK_WORDS[kind]}`).join(', ');
}
