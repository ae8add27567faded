/** Assignment of frames to people. */
import { signal } from '@preact/signals';
import { Button } from '../panels/parts/controls';
import { plural } from '../common/format';
import { Icon } from '../common/icons';
import { canManage, state } from '../store/state';
import { AccountHint } from '../panels/parts/account-hint';
import { assignmentsOf, framesOf, type Standing } from './model';
import { FrameRange } from './frame-states';
import { overview, put, visit } from './store';

const given = signal({ name: '', first: 0, last: null as number | null });

export function People() {
  const runs = assignmentsOf(overview.value);
  return (
    <>
      {runs.length === 0 && <p class="soft empty">No frames are assigned.</p>}
      <ul class="findings">
        {runs.map((run) => (
          <li key={run.first}>
            <Assigned run={run} />
          </li>
        ))}
      </ul>
      {canManage.value && <Give />}
    </>
  );
}

function Assigned({ run }: { run: Standing }) {
  const frames = run.last! - run.first! + 1;
  const own = run.assignee === state.me.value?.author;
  return (
    <div class="assigned">
      <button type="button" class="menu-item" onClick={() => visit(run.first, null)}>
        <Icon name="people" />
        <span class="what">
          {run.assignee}
          {own && ' (you)'}
          <span class="soft">
            {framesOf(run)} · {plural(frames, 'frame')}
          </span>
        </span>
      </button>
      {canManage.value && (
        <Button
          icon="close"
          tip={`Unassign ${framesOf(run)}`}
          small
          onClick={() => void put({ first: run.first!, last: run.last!, assignee: '' })}
        />
      )}
    </div>
  );
}

function Give() {
  const { name, first, last } = given.value;
  const until = last ?? (state.sequence.value?.frames ?? 1) - 1;
  const give = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (name.trim() && (await put({ first, last: until, assignee: name.trim() }))) {
      given.value = { name: '', first: 0, last: null };
    }
  };
  return (
    <form class="review-form" onSubmit={(event) => void give(event)}>
      <FrameRange
        first={first}
        last={until}
        onChange={(range) => (given.value = { ...given.peek(), ...range })}
      />
      <label>
        Person
        <input
          type="text"
          list="review-people"
          maxLength={128}
          value={name}
          onInput={(event) => (given.value = { ...given.peek(), name: event.currentTarget.value })}
        />
      </label>
      <AccountHint id="review-people" name={name} />
      <button type="submit" class="button primary" disabled={!name.trim()}>
        Assign frames
      </button>
    </form>
  );
}
