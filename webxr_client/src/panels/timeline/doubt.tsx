/** Actions on a doubtful frame and the stretch around it, or on a run that stopped for doubt. */
import { actions } from '../../store/actions';
import { DOUBT_PREFIX, halted, namesOf, stretch, type Stretch, unsure } from '../../engine/review';
import { canEdit, canReview, state, trackingJob } from '../../store/state';
import { Button } from '../parts/controls';
import { plural } from '../../common/format';

export function Doubt() {
  const labels = unsure.value;
  const found = stretch.value;
  const stops = halted.value?.at === state.frame.value;
  if (!canEdit.value || trackingJob.value || (!found && !stops)) return null;
  return (
    <span class={`pill${found ? ' warn' : ''}`} role="status">
      <span class="doubt-text name">{textOf(labels, found)}</span>
      {labels.length > 0 && canReview.value && (
        <Button
          label="Confirm"
          tip="Confirm the labels: their points count as painted"
          keys="Shift Y"
          kind="outlined"
          small
          onClick={() => void actions.tracking.acceptFrame()}
        />
      )}
      {found && <OfStretch found={found} />}
      <Continue doubtful={labels.length > 0} />
    </span>
  );
}

/** Button that continues the run that stopped here, or tracks on the labels `doubtful` here. */
function Continue({ doubtful }: { doubtful: boolean }) {
  const run = halted.value;
  const waits = run !== null && run.at === state.frame.value && run.stop !== run.at;
  if (!waits && !doubtful) return null;
  return (
    <Button
      label={waits ? `Continue to ${run.stop}` : 'Continue'}
      tip="Track forward from this frame"
      kind="outlined"
      small
      onClick={() => actions.tracking.continueRun()}
    />
  );
}

function textOf(labels: readonly number[], found: Stretch | null): string {
  if (labels.length > 0) return `${DOUBT_PREFIX}: ${namesOf(labels)}`;
  return found ? `Doubtful nearby: ${namesOf(found.labels)}` : 'Not doubtful here';
}

function OfStretch({ found }: { found: Stretch }) {
  const { start, stop } = found;
  const frames = start === stop ? `frame ${start}` : `frames ${start} to ${stop}`;
  return (
    <span class="group stretch" role="group" aria-label={`Doubtful: ${frames}`}>
      <span class="number" data-tip={plural(stop - start + 1, 'doubtful frame')}>
        {start === stop ? `Frame ${start}` : `Frames ${start} – ${stop}`}
      </span>
      {canReview.value && (start < stop || unsure.value.length === 0) && <Button icon="check" tip={`Confirm ${frames} as correct`} small onClick={() => void actions.tracking.acceptStretch()} />}
      <Button icon="trash" tip={`Clear the tracked labels in ${frames}`} small onClick={() => void actions.tracking.clearStretch()} />
      <Button icon="track" tip={`Track ${frames} again from the nearest certain frame`} small onClick={() => actions.tracking.trackStretch()} />
    </span>
  ); // prettier-ignore
}
