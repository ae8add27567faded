/** Conditions for recordings that only the server can check: labels, people, tasks. */
import type { ProjectInfo } from '../../protocol/values';
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import {
  NO_CONDITIONS,
  projects,
  search,
  TASK_STATES,
  TASK_WORDS,
  type Conditions,
} from '../../engine/recordings/projects';
import { attempt } from '../../engine/recordings/recordings';
import { Button } from '../parts/controls';
import { Choice } from '../parts/fields';
import { PopoverButton } from '../parts/popover';

/** Debounce of typing before a request to the server, milliseconds. */
const PAUSE_MS = 200;

const conditions = signal(NO_CONDITIONS);
const open = signal(false);
/** Ids of the recordings that meet the conditions; null: there are no conditions. */
export const filtered = signal<ReadonlySet<string> | null>(null);

/** A button that opens the conditions, with their number. */
export function Filter() {
  const { value } = conditions;
  useEffect(() => {
    let stale = false;
    const timer = setTimeout(() => {
      void attempt('The search failed', async () => {
        const met = await search(value);
        if (!stale) filtered.value = met;
      });
    }, PAUSE_MS);
    return () => {
      stale = true;
      clearTimeout(timer);
    };
  }, [value]);
  const count = Object.values(value).filter(Boolean).length;
  return (
    <PopoverButton
      open={open}
      icon="filter"
      pressed={count > 0}
      button={{ label: count > 0 ? `Filter: ${count}` : 'Filter', class: '' }}
      tip="Only recordings with a class, a label, a person or a task"
      label="Filter"
    >
      <Fields />
      <Button
        label="Show all"
        disabled={count === 0}
        onClick={() => (conditions.value = NO_CONDITIONS)}
      />
    </PopoverButton>
  );
}

const FIELDS = [
  ['class', 'Class'],
  ['label', 'Label'],
  ['person', 'Person'],
] as const;

const STATES = [
  ['', 'Any state'],
  ...TASK_STATES.map((kind) => [kind, `Task ${TASK_WORDS[kind]}`] as const),
] as const;

function Fields() {
  const { value } = conditions;
  const change = (patch: Partial<Conditions>): void => {
    conditions.value = { ...conditions.peek(), ...patch };
  };
  return (
    <div class="conditions stack" role="group" aria-label="Only recordings with">
      {FIELDS.map(([name, words]) => (
        <input
          key={name}
          class="field"
          aria-label={words}
          placeholder={words}
          maxLength={256}
          list={name === 'person' ? 'project-people' : undefined}
          value={value[name]}
          onInput={(event) => change({ [name]: event.currentTarget.value })}
        />
      ))}
      <datalist id="project-people">
        {[...new Set(projects.value.flatMap(peopleOf))].map((person) => (
          <option key={person} value={person} />
        ))}
      </datalist>
      <Choice
        label="State of a task"
        value={value.state}
        choices={STATES}
        onChange={(kind) => change({ state: kind })}
      />
    </div>
  );
}

function peopleOf({ roles, people }: ProjectInfo): readonly string[] {
  return [...Object.keys(roles), ...Object.keys(people)].filter(Boolean);
}
