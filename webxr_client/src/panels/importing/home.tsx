/** Recordings on the start page, by project, with a search and what has been done of each. */
import { signal, useSignal } from '@preact/signals';
import { useEffect, useState } from 'preact/hooks';
import {
  type Conditions,
  createProject,
  type Group,
  grouped,
  NO_CONDITIONS,
  type Project,
  projectPath,
  projects,
  refreshProjects,
  search,
  settled,
  type Statistics,
  TASK_STATES,
  TASK_WORDS,
  tasksOf,
} from '../../engine/projects';
import { attempt } from '../../engine/recordings';
import { plural, shortCount } from '../../common/format';
import { Icon } from '../../common/icons';
import { api } from '../../net/rest';
import { actions } from '../../store/actions';
import { canManage, type SequenceSummary } from '../../store/state';
import { Button, NameField } from '../parts/controls';
import { PopoverButton } from '../parts/popover';
import { matching, RecordingName, renamingRecording, Row } from './recordings';

/** So many recordings are told apart at a glance. */
const SEARCHED_FROM = 4;
/** Rows of a project that are drawn at first. */
const DRAWN = 100;
/** With more recordings, projects begin closed. */
const OPEN_UP_TO = 50;
/** Pause in typing after which the server is asked, milliseconds. */
const PAUSE_MS = 200;

const conditions = signal(NO_CONDITIONS);
/** Recordings that meet the conditions; null: there are none to meet. */
const found = signal<ReadonlySet<string> | null>(null);
const naming = signal(false);

export function Recordings({ sequences }: { sequences: readonly SequenceSummary[] }) {
  const [text, setText] = useState('');
  useEffect(() => void refreshProjects(), [sequences]);
  const several = projects.value.length > 1;
  const met = sequences.filter(({ id }) => found.value?.has(id) ?? true);
  const rows = matching(met, text);
  const sought = text !== '' || found.value !== null;
  return (
    <>
      <header class="recordings-header">
        <h1>Recordings</h1>
        {(several || sequences.length >= SEARCHED_FROM) && (
          <input
            class="field"
            type="search"
            aria-label="Search the recordings"
            placeholder={`Search ${plural(sequences.length, 'recording')}`}
            value={text}
            onInput={(event) => setText(event.currentTarget.value)}
          />
        )}
      </header>
      {(several || sequences.length >= SEARCHED_FROM) && <ConditionFields />}
      {sought && rows.length === 0 && <p class="soft">No recording matches the search</p>}
      <div class="projects">
        {grouped(rows, projects.value).map((group) =>
          sought && group.rows.length === 0 ? null : (
            <ProjectGroup
              key={group.project.id}
              group={group}
              alone={!several}
              opened={sought || sequences.length <= OPEN_UP_TO}
            />
          ),
        )}
      </div>
      {canManage.value && <NewProject />}
    </>
  );
}

const FIELDS = [
  ['class', 'Class'],
  ['label', 'Label'],
  ['person', 'Person'],
] as const;

/** Conditions for the server: points of a class or label, a person, a task's state. */
function ConditionFields() {
  const { value } = conditions;
  const change = (patch: Partial<Conditions>): void => {
    conditions.value = { ...conditions.peek(), ...patch };
  };
  useEffect(() => {
    let stale = false;
    const timer = setTimeout(() => {
      void attempt('The search failed', async () => {
        const met = await search(value);
        if (!stale) found.value = met;
      });
    }, PAUSE_MS);
    return () => {
      stale = true;
      clearTimeout(timer);
    };
  }, [value]);
  return (
    <div class="conditions" role="group" aria-label="Only recordings with">
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
      <select
        class="field"
        aria-label="State of a task"
        value={value.state}
        onChange={(event) => change({ state: event.currentTarget.value })}
      >
        <option value="">Any state</option>
        {TASK_STATES.map((kind) => (
          <option key={kind} value={kind}>
            Task {TASK_WORDS[kind]}
          </option>
        ))}
      </select>
    </div>
  );
}

function peopleOf({ roles, people }: Project): readonly string[] {
  return [...Object.keys(roles), ...Object.keys(people)].filter(Boolean);
}

interface GroupProps {
  group: Group;
  /** It is the only project. */
  alone: boolean;
  opened: boolean;
}

function ProjectGroup({ group: { project, rows }, alone, opened }: GroupProps) {
  const [open, setOpen] = useState<boolean | null>(null);
  const tasks = project.tasks ?? {};
  if (alone && tasksOf(tasks) === 0) return <Rows rows={rows} />;
  const shown = alone || (open ?? opened);
  return (
    <section class="project" aria-label={project.name}>
      <div class="project-head">
        <button
          type="button"
          class="button project-name"
          aria-expanded={shown}
          onClick={() => setOpen(!shown)}
        >
          <Icon name={shown ? 'chevron' : 'next'} />
          <strong class="name">{project.name}</strong>
          <span class="soft number">{plural(rows.length, 'recording')}</span>
        </button>
        <Progress tasks={tasks} rows={rows} />
        {tasksOf(tasks) > 0 && project.role !== 'viewer' && (
          <Button
            label="Next task"
            kind="outlined"
            small
            tip={`Open your next task in ${project.name}`}
            onClick={() => void actions.nextTask(project.id)}
          />
        )}
        <FiguresButton project={project.id} />
        {canManage.value && <SettingsButton project={project} />}
      </div>
      {shown && <Rows rows={rows} />}
    </section>
  );
}

function Rows({ rows }: { rows: readonly SequenceSummary[] }) {
  const [all, setAll] = useState(false);
  return (
    <ul class="recordings">
      {(all ? rows : rows.slice(0, DRAWN)).map((row) => (
        <li key={row.id} class="recording-line">
          {renamingRecording.value === row.id ? <RecordingName row={row} /> : <Row row={row} />}
        </li>
      ))}
      {!all && rows.length > DRAWN && (
        <li>
          <Button label={`All ${plural(rows.length, 'recording')}`} onClick={() => setAll(true)} />
        </li>
      )}
      {rows.length === 0 && (
        <li class="soft">No recordings yet: import recordings or move them here</li>
      )}
    </ul>
  );
}

interface ProgressProps {
  tasks: NonNullable<Project['tasks']>;
  rows: readonly SequenceSummary[];
}

/** Tasks by state; of a project without tasks the frames that have labels. */
function Progress({ tasks, rows }: ProgressProps) {
  const all = tasksOf(tasks);
  const frames = rows.reduce((sum, row) => sum + row.frames, 0);
  const labelled = rows.reduce((sum, row) => sum + row.labelled, 0);
  const told = TASK_STATES.filter((kind) => tasks[kind])
    .map((kind) => `${tasks[kind]} ${TASK_WORDS[kind]}`)
    .join(', ');
  const words = all > 0 ? `${tasksOf(tasks, 'accepted')} of ${plural(all, 'task')}` : `${labelled} of ${plural(frames, 'frame')}`; // prettier-ignore
  return (
    <span class="part project-progress" data-tip={told || 'Frames with labels'}>
      <span class="soft number">{words}</span>
      <span class="progress states" aria-hidden="true">
        {all === 0 && <span style={{ width: `${(100 * labelled) / Math.max(1, frames)}%` }} />}
        {[...TASK_STATES].reverse().map((kind) => (
          <span
            key={kind}
            data-state={kind}
            style={{ width: `${(100 * (tasks[kind] ?? 0)) / Math.max(1, all)}%` }}
          />
        ))}
      </span>
    </span>
  );
}

function SettingsButton({ project: { id, name } }: { project: Group['project'] }) {
  return (
    <Button
      label="Settings"
      tip={`People, categories, tasks and webhooks of ${name}`}
      small
      onClick={() => (settled.value = id)}
    />
  );
}

function FiguresButton({ project }: { project: string }) {
  const open = useSignal(false);
  return (
    <PopoverButton open={open} icon="points" tip="Points, objects, hours" label="Figures" small>
      <FiguresTable project={project} />
    </PopoverButton>
  );
}

function FiguresTable({ project }: { project: string }) {
  const figures = useSignal<Statistics | null>(null);
  useEffect(() => {
    void attempt('The figures did not load', async () => {
      figures.value = await api<Statistics>('GET', `${projectPath(project)}/statistics`);
    });
  }, [project]);
  if (!figures.value) return <p class="soft">Counting…</p>;
  const { points, objects, hours, classes, people } = figures.value;
  const row = (name: string, cells: readonly string[]) => (
    <tr key={name}>
      <th scope="row">{name}</th>
      {cells.map((cell, k) => (
        <td key={k} class="number">
          {cell}
        </td>
      ))}
    </tr>
  );
  return (
    <table class="figures">
      <thead>
        <tr>
          <th>Class</th>
          <th>Points</th>
          <th>Objects</th>
          <th>Hours</th>
        </tr>
      </thead>
      <tbody>
        {classes.map((each) =>
          row(each.name || 'no class', [
            shortCount(each.points),
            String(each.objects),
            each.hours.toFixed(2),
          ]),
        )}
        {row('All', [shortCount(points), String(objects), hours.toFixed(2)])}
        {people.map(({ name, hours: own }) => row(name, ['', '', own.toFixed(2)]))}
      </tbody>
    </table>
  );
}

function NewProject() {
  const [only, ...others] = projects.value;
  if (!naming.value) {
    return (
      <div class="group">
        <Button icon="plus" label="New project" onClick={() => (naming.value = true)} />
        {only && others.length === 0 && <SettingsButton project={only} />}
      </div>
    );
  }
  return (
    <NameField
      name=""
      maxLength={200}
      onFinish={(name) => {
        naming.value = false;
        if (name) void createProject(name);
      }}
    />
  );
}
