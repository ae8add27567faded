/** Long work under way, with a way to stop it. */
import { signal } from '@preact/signals';
import { actions } from '../../store/actions';
import type { Job } from '../../protocol/messages';
import { canCancel, isActive, isMine, state } from '../../store/state';
import { Button, JobHead, Progress } from '../parts/controls';
import { bytes, percent, plural } from '../../common/format';
import { ownImports } from '../../engine/recordings/imports';
import { PopoverButton } from '../parts/popover';
import { ImportCard } from './import-card';

const TITLE = {
  import: 'Importing',
  tracking: 'Tracking',
  export: 'Exporting',
  prediction: 'Predicting',
  fitting: 'Fitting boxes',
  alignment: 'Aligning sensors',
} as const;

/** Cards of the user's own jobs; jobs of other people are shown beside the server's state. */
export function JobCards() {
  const shown = new Set(ownImports.value);
  const jobs = state.jobs.value.filter((job) => isActive(job) && isMine(job) && !shown.has(job));
  return (
    <>
      {state.uploads.value.map((upload) => (
        <div key={upload.name} class="card job stack" role="status">
          <JobHead
            title="Sending"
            about={upload.name}
            figure={`${bytes(upload.sent)} of ${bytes(upload.total)}`}
          />
          <Progress share={upload.sent / Math.max(1, upload.total)} label={upload.name} />
        </div>
      ))}
      <ImportCard />
      {jobs.map((job) => (
        <div key={job.id} class="card job stack" role="status">
          <Running job={job} about={job.message} />
        </div>
      ))}
    </>
  );
}

const othersOpen = signal(false);

/** Jobs of other people, folded, with recording and person. */
export function OthersJobs() {
  const jobs = state.jobs.value.filter((job) => isActive(job) && !isMine(job));
  if (jobs.length === 0) return null;
  const nameOf = (id: string | null): string =>
    state.sequences.value?.find((row) => row.id === id)?.name ?? id ?? 'a new recording';
  return (
    <PopoverButton
      open={othersOpen}
      icon="people"
      button={{ label: String(jobs.length), class: 'others-jobs' }}
      tip={`${plural(jobs.length, 'job')} of other people`}
      label="Jobs of other people"
      class="form"
    >
      {jobs.map((job) => (
        <div key={job.id} class="stack">
          <Running job={job} about={`${nameOf(job.sequence)} · ${job.owner}`} />
        </div>
      ))}
    </PopoverButton>
  );
}

function Running({ job, about }: { job: Job; about: string }) {
  const tracking = job.kind === 'tracking';
  return (
    <>
      <JobHead
        title={TITLE[job.kind]}
        about={job.state === 'queued' ? `queued · ${about}` : about}
        {...(job.progress > 0 && { figure: percent(job.progress) })}
      />
      <Progress share={job.progress} label={TITLE[job.kind]} />
      {canCancel(job) && (
        <div class="form-end">
          {tracking && (
            <Button
              label="Stop and keep"
              tip="Keep the frames tracked so far"
              onClick={() => void actions.tracking.cancelJob(job.id, true)}
            />
          )}
          <Button
            label="Cancel"
            tip={tracking ? 'Stop and discard the tracked labels' : 'Stop and discard the result'}
            onClick={() => void actions.tracking.cancelJob(job.id)}
          />
        </div>
      )}
    </>
  );
}
