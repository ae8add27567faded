/** A run that stopped because it was unsure, or a doubtful frame: accept it, or go on from it. */
import { actions } from '../actions';
import { halted, namesOf, unsure } from '../engine/review';
import { canEdit, canReview, state, trackingJob } from '../state';
import { Button } from './controls';

export function Doubt() {
  const labels = unsure.value;
  const run = halted.value;
  const here = run?.at === state.frame.value;
  if (!canEdit.value || trackingJob.value || (labels.length === 0 && !here)) return null;
  const waits = run !== null && here && run.stop !== run.at;
  return (
    <span class={`chip doubt${labels.length > 0 ? ' warn' : ''}`} role="status">
      {labels.length > 0 ? `Not sure of ${namesOf(labels)} here` : 'Mended'}
      {labels.length > 0 && canReview.value && (
        <Button
          label="Accept"
          tip="Right as it is: its points count as painted"
          kind="outlined"
          small
          onClick={() => void actions.acceptHere()}
        />
      )}
      {(waits || labels.length > 0) && (
        <Button
          label={waits ? `Continue to ${run.stop}` : 'Continue'}
          tip="Track on from this frame"
          kind="outlined"
          small
          onClick={() => actions.continueRun()}
        />
      )}
    </span>
  );
}
