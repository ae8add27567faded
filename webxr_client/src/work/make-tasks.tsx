/** The form that makes tasks: of the open recording, of a range of its frames, or of a project. */
import type { ProjectInfo } from '../protocol/values';
import { useState } from 'preact/hooks';
import { plural } from '../common/format';
import { rowOf } from '../engine/recordings/recordings';
import { AccountHint } from '../panels/parts/account-hint';
import { FrameRange } from './frames';
import { Button } from '../panels/parts/controls';
import { Choice, Field } from '../panels/parts/fields';
import { addTasks } from './queue';

interface MakeTasksProps {
  of: ProjectInfo;
  /** The open recording, which is offered first; without it all are. */
  open?: { readonly id: string; readonly frames: number } | null;
  onMade?: () => void;
}

export function MakeTasks({ of, open = null, onMade }: MakeTasksProps) {
  const [recording, setRecording] = useState(open?.id ?? '');
  const [range, setRange] = useState({ first: 0, last: Infinity });
  const [{ every, assignee, people }, set] = useState({ every: '', assignee: '', people: 1 });
  const change = (patch: object): void => set((before) => ({ ...before, ...patch }));
  const nameOf = (id: string) => (id === open?.id ? 'this recording' : (rowOf(id)?.name ?? id));
  const isOpen = recording === open?.id;
  const last = Math.min(range.last, (open?.frames ?? 1) - 1);
  const submit = (event: Event): void => {
    event.preventDefault();
    const frames = isOpen ? `${range.first}:${last + 1}` : null;
    const recordings = recording ? [recording] : null;
    const wanted = { recordings, frames, every: Number(every) || null, assignee: assignee.trim(), people }; // prettier-ignore
    void addTasks(wanted, of.id).then(onMade);
  };
  return (
    <form class="work-form stack" onSubmit={submit}>
      <label>
        Recordings
        <Choice
          value={recording}
          choices={[
            ['', `all ${plural(of.recordings.length, 'recording')} of the project`],
            ...of.recordings.map((id) => [id, nameOf(id)] as const),
          ]}
          onChange={setRecording}
        />
      </label>
      {isOpen && <FrameRange first={range.first} last={last} onChange={setRange} />}
      <div class="halves">
        <Field
          label="Frames per task"
          type="number"
          min={1}
          placeholder="all"
          value={every}
          onInput={({ currentTarget }) => change({ every: currentTarget.value })}
        />
        <Field
          label="Annotators per task"
          tip="Each annotator gets an own copy and does not see the other copies"
          type="number"
          min={1}
          max={9}
          value={people}
          onInput={({ currentTarget }) => change({ people: Number(currentTarget.value) || 1 })}
        />
      </div>
      <Field
        label="Assignee"
        maxLength={128}
        placeholder="first free annotator"
        list="task-people"
        value={assignee}
        onInput={({ currentTarget }) => change({ assignee: currentTarget.value })}
      />
      <AccountHint id="task-people" name={assignee} />
      <Button submit label="Make tasks" kind="primary" disabled={of.recordings.length === 0} />
    </form>
  );
}
