/** Settings of a project: its recordings, which are moved in or imported, and its tasks. */
import { useEffect, useState } from 'preact/hooks';
import {
  importEach,
  importInto,
  type Project,
  projects,
  settled,
  TASK_WORDS,
} from '../engine/projects';
import { rowOf } from '../engine/recordings';
import { pickFiles } from '../panels/importing/files';
import { Button, Check } from '../panels/parts/controls';
import { actions } from '../store/actions';
import { state } from '../store/state';
import { MakeTasks } from '../work/make-tasks';
import { taskWords } from '../work/queue';
import { deleteTask, loadProjectTasks, projectTasks, save } from './settings';

const titleOf = (recording: string): string => rowOf(recording)?.name ?? recording;

export function Recordings({ of }: { of: Project }) {
  const others = (state.sequences.value ?? []).filter(({ project }) => project !== of.id);
  return (
    <>
      <ul class="settings-rows">
        {of.recordings.map((id) => (
          <li key={id}>
            <span class="name">{titleOf(id)}</span>
          </li>
        ))}
      </ul>
      {of.recordings.length === 0 && <p class="soft">No recordings yet.</p>}
      {others.length > 0 && (
        <select
          class="field"
          aria-label="Move a recording here"
          value=""
          onChange={({ currentTarget }) => {
            void save({ recordings: [currentTarget.value] });
            currentTarget.value = '';
          }}
        >
          <option value="">Move a recording of another project here…</option>
          {others.map(({ id, name, project }) => (
            <option key={id} value={id}>
              {name} ({projects.value.find((each) => each.id === project)?.name ?? project})
            </option>
          ))}
        </select>
      )}
      <Import of={of} />
    </>
  );
}

/** Imports into the project: of files, or of a path on the server. */
function Import({ of: { id } }: { of: Project }) {
  const [path, setPath] = useState('');
  const [each, setEach] = useState(true);
  const begin = (run: () => void): void => {
    importInto.value = id;
    settled.value = null;
    run();
  };
  const submit = (event: Event): void => {
    event.preventDefault();
    const given = path.trim();
    if (given) begin(() => void (each ? importEach(given, id) : actions.importPath(given)));
  };
  return (
    <section class="settings-import" aria-label="Import into the project">
      <div class="group">
        <Button label="Import files" kind="outlined" onClick={() => begin(() => pickFiles())} />
        <Button
          label="Import a folder"
          kind="outlined"
          onClick={() => begin(() => pickFiles(true))}
        />
      </div>
      <form class="settings-add" onSubmit={submit}>
        <input
          class="field"
          aria-label="Path on the server"
          placeholder="A path on the server"
          spellcheck={false}
          value={path}
          onInput={(event) => setPath(event.currentTarget.value)}
        />
        <button type="submit" class="button outlined" disabled={!path.trim()}>
          Import
        </button>
      </form>
      <Check
        label="Import each file or folder in it as a recording"
        checked={each}
        onChange={setEach}
      />
    </section>
  );
}

export function ProjectTasks({ of }: { of: Project }) {
  useEffect(() => void loadProjectTasks(), [of.id]);
  return (
    <>
      <MakeTasks of={of} onMade={() => void loadProjectTasks()} />
      <ul class="settings-rows">
        {projectTasks.value.map((task) => (
          <li key={task.number}>
            <span class="name">{taskWords(task)}</span>
            <span class="soft">
              {TASK_WORDS[task.state]}
              {task.assignee && ` · ${task.assignee}`}
            </span>
            <Button
              icon="trash"
              tip={`Delete task ${task.number}; labels stay`}
              small
              onClick={() => void deleteTask(task)}
            />
          </li>
        ))}
      </ul>
    </>
  );
}
