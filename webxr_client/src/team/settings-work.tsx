/** Settings of a project: its recordings, which are moved in or imported, and its tasks. */
import { useEffect } from 'preact/hooks';
import { importInto, type Project, projects, settled, TASK_WORDS } from '../engine/projects';
import { rowOf } from '../engine/recordings';
import { ImportBox } from '../panels/importing/import-box';
import { Button } from '../panels/parts/controls';
import { state } from '../store/state';
import { MakeTasks } from '../work/make-tasks';
import { taskWords } from '../work/queue';
import { deleteTask, loadProjectTasks, projectTasks, save } from './settings';

const titleOf = (recording: string): string => rowOf(recording)?.name ?? recording;

export function Recordings({ of }: { of: Project }) {
  const others = (state.sequences.value ?? []).filter(({ project }) => project !== of.id);
  return (
    <>
      <ul class="settings-rows stack">
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
      <ImportBox
        onBegin={() => {
          importInto.value = of.id;
          settled.value = null;
        }}
      />
    </>
  );
}

export function ProjectTasks({ of }: { of: Project }) {
  useEffect(() => void loadProjectTasks(), [of.id]);
  return (
    <>
      <MakeTasks of={of} onMade={() => void loadProjectTasks()} />
      <ul class="settings-rows stack">
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
