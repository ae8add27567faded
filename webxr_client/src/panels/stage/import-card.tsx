/** One card for all imports of the user: their progress, and each with its name. */
import { useSignal } from '@preact/signals';
import { cancelImport } from '../../engine/recordings/import-parts';
import { closeImports, importName, ownImports } from '../../engine/recordings/imports';
import { percent, plural } from '../../common/format';
import type { Job } from '../../protocol/messages';
import { actions } from '../../store/actions';
import { canCancel, isActive } from '../../store/state';
import { Button, JobHead, Progress } from '../parts/controls';
import { inSight, listStyle, useSight } from '../parts/scrolled';

const WORDS = { queued: 'waits', running: '', done: 'imported', failed: 'failed', cancelled: 'stopped' } as const; // prettier-ignore

export function ImportCard() {
  const open = useSignal(false);
  const jobs = ownImports.value;
  const active = jobs.filter(isActive);
  if (jobs.length < 2 && active.length === 0) return null;
  const now = active.find(({ state }) => state === 'running') ?? active[0];
  const share = jobs.reduce((sum, job) => sum + (isActive(job) ? job.progress : 1), 0);
  return (
    <section class="card job imports stack" aria-label="Imports">
      <div role="status">
        <JobHead title={title(jobs)} about={summary(jobs, now)} />
      </div>
      {now && <Progress share={share / jobs.length} label="Imports" />}
      {open.value && jobs.length > 1 && <Each jobs={jobs} />}
      <div class="form-end">
        {jobs.length > 1 && (
          <Button
            label={open.value ? 'Hide the list' : 'Show each'}
            expanded={open.value}
            onClick={() => (open.value = !open.value)}
          />
        )}
        <End active={active} several={jobs.length > 1} />
      </div>
    </section>
  );
}

function End({ active, several }: { active: readonly Job[]; several: boolean }) {
  if (active.length === 0) return <Button label="Close" onClick={closeImports} />;
  return (
    <Button
      label={several ? 'Cancel all' : 'Cancel'}
      tip="Stop the imports that are not finished"
      disabled={!active.every(canCancel)}
      onClick={() => active.forEach(cancelImport)}
    />
  );
}

function title(jobs: readonly Job[]): string {
  const done = jobs.filter(({ state }) => state === 'done').length;
  if (!jobs.some(isActive)) return `Imported ${plural(done, 'recording')}`;
  return `Importing ${jobs.length > 1 ? plural(jobs.length, 'recording') : importName(jobs[0]!)}`;
}

/** "7 done · 1 failed · drive_07". */
function summary(jobs: readonly Job[], now: Job | undefined): string {
  const count = (...kinds: readonly Job['state'][]): number =>
    jobs.filter(({ state }) => kinds.includes(state)).length;
  const parts = [
    jobs.length > 1 && `${count('done')} done`,
    count('failed') > 0 && `${count('failed')} failed`,
    count('cancelled') > 0 && `${count('cancelled')} stopped`,
    now && (jobs.length > 1 ? importName(now) : now.state === 'queued' ? 'waits' : now.message),
  ];
  return parts.filter(Boolean).join(' · ');
}

function Each({ jobs }: { jobs: readonly Job[] }) {
  const [box, sight] = useSight();
  const [from, until] = inSight(sight, 0, jobs.length);
  return (
    <div
      ref={box}
      class="import-files jobs small"
      role="region"
      aria-label="Each import"
      tabIndex={0}
    >
      <ul class="rows" style={listStyle(jobs.length, from)}>
        {jobs.slice(from, until).map((job) => (
          <ImportRow key={job.id} job={job} />
        ))}
      </ul>
    </div>
  );
}

function ImportRow({ job }: { job: Job }) {
  const name = importName(job);
  const { state, sequence } = job;
  const words = state === 'running' ? percent(job.progress) : WORDS[state];
  return (
    <li class="line" data-state={state}>
      <span class="name grow">{name}</span>
      <span
        class={`name number ${job.error === null ? 'soft' : 'bad'}`}
        data-tip={job.error ?? undefined}
      >
        {job.error ?? words}
      </span>
      {isActive(job) && canCancel(job) && (
        <Button
          label="Cancel"
          tip={`Stop importing ${name}`}
          small
          onClick={() => cancelImport(job)}
        />
      )}
      {state === 'done' && sequence !== null && (
        <Button
          label="Open"
          tip={`Open ${name}`}
          kind="outlined"
          small
          onClick={() => actions.recordings.openSequence(sequence)}
        />
      )}
    </li>
  );
}
