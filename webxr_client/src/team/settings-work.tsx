/** Settings of a project: its recordings, which are moved in or imported, and its tasks. */
import type { ProjectInfo } from '../protocol/values';
import { useEffect } from 'preact/hooks';
import { importInto, projects, settled, TASK_WORDS } from '../engine/recordings/projects';
import { rowOf } from '../engine/recordings/recordings';
import { ImportBox } from '../panels/importing/import-box';
import { Choice } from '../panels/parts/fields';
import { Button } from '../panels/parts/controls';
import { state } from '../store/state';
import { MakeTasks } from '../work/make-tasks';
import { taskWords } from '../work/queue';
import { deleteTask, loadProjectTasks, projectTasks, save } from './settings';

const titleOf = (recording: string): string => rowOf(recording)?.name ?? recording;

const projectTitle = (id: string): string =>
  projects.value.find((each) => each.id === id)?.name ?? id;

export function Recordings({ of }: { of: ProjectInfo }) {
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
        <Choice
          label="Move a recording here"
          value=""
          choices={[
            ['', 'Move a recording of another project here…'],
            ...others.map(
              ({ id, name, project }) => [id, `${name} (${projectTitle(project)})`] as const,
            ),
          ]}
          onChange={(id) => void save({ recordings: [id] })}
        />
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

export function ProjectTasks({ of }: { of: ProjectInfo }) {
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
