/** Long work under way, with a way to stop it. */
import { actions } from '../../store/actions';
import type { Job } from '../../protocol/messages';
import { isActive, state } from '../../store/state';
import { Button, Progress } from '../parts/controls';
import { bytes } from '../../common/format';

const TITLE = {
  import: 'Importing',
  tracking: 'Tracking',
  export: 'Exporting',
  prediction: 'Predicting',
  fitting: 'Fitting boxes',
} as const;

export function JobCards() {
  const jobs = state.jobs.value.filter(isActive);
  return (
    <>
      {state.uploads.value.map((upload) => (
        <div key={upload.name} class="card job" role="status">
          <div class="job-head">
            <strong>Sending {upload.name}</strong>
            <span class="soft number">
              {bytes(upload.sent)} of {bytes(upload.total)}
            </span>
          </div>
          <Progress share={upload.sent / Math.max(1, upload.total)} label={upload.name} />
        </div>
      ))}
      {jobs.map((job) => (
        <Running key={job.id} job={job} />
      ))}
    </>
  );
}

function Running({ job }: { job: Job }) {
  const tracking = job.kind === 'tracking';
  return (
    <div class="card job" role="status">
      <div class="job-head">
        <strong>{TITLE[job.kind]}</strong>
        <span class="soft name">
          {job.state === 'queued' ? 'waiting for its turn' : job.message}
        </span>
        <span class="number">{Math.round(job.progress * 100)} %</span>
      </div>
      <Progress share={job.progress} label={TITLE[job.kind]} />
      <div class="job-end">
        {tracking && (
          <Button
            label="Stop and keep"
            tip="Keep the frames tracked so far"
            onClick={() => void actions.cancelJob(job.id, true)}
          />
        )}
        <Button
          label="Cancel"
          tip={tracking ? 'Stop and leave every label as it was' : 'Stop, and leave nothing behind'}
          onClick={() => void actions.cancelJob(job.id)}
        />
      </div>
    </div>
  );
}
