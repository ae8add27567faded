/** The head of a project in the table of recordings, and its figures. */
import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import {
  type Group,
  nextWork,
  projectPath,
  projects,
  settled,
  TASK_STATES,
  TASK_WORDS,
  tasksOf,
} from '../../engine/recordings/projects';
import { attempt } from '../../engine/recordings/recordings';
import { plural, shortCount } from '../../common/format';
import { Icon } from '../../common/icons';
import { api } from '../../net/rest';
import type { ProjectInfo, Statistics } from '../../protocol/values';
import { actions } from '../../store/actions';
import { canManage, state, type SequenceSummary } from '../../store/state';
import { Button } from '../parts/controls';
import { Table } from '../parts/fields';
import { PopoverButton } from '../parts/popover';

interface ProjectHeadProps {
  project: Group['project'];
  rows: readonly SequenceSummary[];
  shown: boolean;
  onFold: () => void;
}

export function ProjectHead({ project, rows, shown, onFold }: ProjectHeadProps) {
  const known = projects.value.find(({ id }) => id === project.id);
  return (
    <div class="project-head line">
      <button type="button" class="button project-name" aria-expanded={shown} onClick={onFold}>
        <Icon name={shown ? 'chevron' : 'next'} />
        <strong class="name">{project.name}</strong>
        <span class="soft number">{plural(rows.length, 'recording')}</span>
      </button>
      <NextWork of={known ? [known] : []} small />
      <Progress tasks={project.tasks ?? {}} rows={rows} />
      <FiguresButton project={project.id} />
      {canManage.value && <SettingsButton project={project} />}
    </div>
  );
}

/** Buttons to the first project of some that has a task to review, and to one to label. */
export function NextWork({ of, small = false }: { of: readonly ProjectInfo[]; small?: boolean }) {
  const { label, review } = nextWork(of, state.me.value?.account ?? '');
  return (
    <>
      {review && (
        <Button
          label="Next to review"
          tip={`Review a task of ${review.name}`}
          kind={small || label ? 'outlined' : 'primary'}
          small={small}
          onClick={() => void actions.recordings.nextTask(review.id, 'review')}
        />
      )}
      {label && (
        <Button
          label="Next task"
          tip={`Label your next task of ${label.name}`}
          kind={small ? 'outlined' : 'primary'}
          small={small}
          onClick={() => void actions.recordings.nextTask(label.id)}
        />
      )}
    </>
  );
}

interface ProgressProps {
  tasks: NonNullable<ProjectInfo['tasks']>;
  rows: readonly SequenceSummary[];
}

/** Tasks by state; of a project without tasks the frames that have labels. */
function Progress({ tasks, rows }: ProgressProps) {
  const all = tasksOf(tasks);
  const frames = rows.reduce((sum, row) => sum + row.frames, 0);
  const labelled = rows.reduce((sum, row) => sum + row.labelled, 0);
  const taskCounts = TASK_STATES.filter((kind) => tasks[kind])
    .map((kind) => `${tasks[kind]} ${TASK_WORDS[kind]}`)
    .join(', ');
  const words = all > 0 ? `${tasksOf(tasks, 'accepted')} of ${plural(all, 'task')}` : `${labelled} of ${plural(frames, 'frame')}`; // prettier-ignore
  return (
    <span class="line small" data-tip={taskCounts || 'Frames with labels'}>
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

export function SettingsButton({ project: { id, name } }: { project: Group['project'] }) {
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

const FIGURES = [['Class'], ['Points'], ['Objects'], ['Hours']] as const;

function FiguresTable({ project }: { project: string }) {
  const figures = useSignal<Statistics | null>(null);
  useEffect(() => {
    void attempt('The figures did not load', async () => {
      figures.value = await api<Statistics>('GET', `${projectPath(project)}/statistics`);
    });
  }, [project]);
  if (!figures.value) return <p class="soft">Counting…</p>;
  const { points, objects, hours, classes, people } = figures.value;
  const rows = [
    ...classes.map((each) => [
      each.name || 'no class',
      shortCount(each.points),
      String(each.objects),
      each.hours.toFixed(2),
    ]),
    ['All', shortCount(points), String(objects), hours.toFixed(2)],
    ...people.map(({ name, hours: own }) => [name, '', '', own.toFixed(2)]),
  ];
  return <Table class="figures small" head={FIGURES} rows={rows} />;
}
