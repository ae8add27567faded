/** Bar at the bottom of the canvas: the object tool's candidate, and actions on it. */
import { peopleStep } from '../../engine/find-people';
import { actions } from '../../store/actions';
import { isStroke, state, trackingJob, type ObjectView } from '../../store/state';
import { preparation } from '../../tools/preparation';
import { deskWay } from '../../tools/ways';
import { Button } from '../parts/controls';
import { plural } from '../../common/format';
import { Icon } from '../../common/icons';

const ASKED = 'Looking for an object…';
const NOTHING = 'No object here';
const POINT = 'Point at an object and click it';

export function ObjectBar() {
  const object = state.object.value;
  const clicks = deskWay(state.brush.value.shape).samples === 'clicks';
  const offers = object !== null && object.levels > 0;
  const shows = clicks || (offers && object.completes);
  if (!shows || !isStroke(state.tool.value) || peopleStep.value) return null;
  return (
    <div class="bar card line wrap" role="status">
      <Icon name="object" />
      {offers && <Offer object={object} />}
      {!offers && <Hint object={object} />}
      {object?.ready === false && <NotReady />}
    </div>
  );
}

function Hint({ object }: { object: ObjectView | null }) {
  const waits = preparation() ?? (state.objectAsked.value ? ASKED : null);
  if (waits === null) return <span>{object ? NOTHING : POINT}</span>;
  return (
    <span>
      <span class="spinner small" /> {waits}
    </span>
  );
}

function Offer({ object: { level, levels, points, taken, completes } }: { object: ObjectView }) {
  return (
    <>
      <Button icon="minus" tip="Smaller part" keys="−" disabled={level === 0} onClick={() => void actions.tools.stepObject(-1)} />
      <Steps level={level} levels={levels} />
      <Button icon="plus" tip="Larger part" keys="+" disabled={level === levels - 1} onClick={() => void actions.tools.stepObject(1)} />
      <span class="number">{plural(points, 'point')}</span>
      {completes && (
        <Button label="Complete to object" kind="outlined" keys="Tab" tip="Take these points instead of the stroke" onClick={() => void actions.tools.completeObject()} />
      )}
      {completes && <Button icon="close" tip="Leave the stroke as it is" keys="Esc" onClick={() => actions.tools.endObject()} />}
      {taken && <span class="soft">Click: add · Alt-click: remove</span>}
      {taken && <TrackOn />}
      {taken && <Button label="Next object" kind="outlined" keys="Esc" onClick={() => actions.tools.endObject()} />}
      {!taken && !completes && <span class="soft">Wheel: smaller or larger · Click: apply</span>}
    </>
  ); // prettier-ignore
}

/** Button that tracks the label forward from here, after the server has counted its points. */
function TrackOn() {
  const frame = state.frame.value;
  if (frame + 1 >= (state.sequence.value?.frames ?? 0)) return null;
  const points = state.timeline.value.rows.get(state.activeLabel.value)?.points[frame] ?? 0;
  return (
    <Button
      icon="track"
      label="Track forward"
      kind="outlined"
      tip="Track the label from this frame to the last"
      disabled={points === 0 || trackingJob.value !== null}
      onClick={() => actions.tracking.continueRun()}
    />
  );
}

/** The levels as a row of marks that grow, the shown one lit. */
function Steps({ level, levels }: { level: number; levels: number }) {
  return (
    <span class="object-levels" role="img" aria-label={`Level ${level + 1} of ${levels}`}>
      {Array.from({ length: levels }, (_, i) => (
        <span key={i} class={i === level ? 'mark on' : 'mark'} style={{ '--step': i }} />
      ))}
    </span>
  );
}

function NotReady() {
  return (
    <span class="soft">
      <span class="spinner small" /> Preparing this frame: the smallest part is offered first
    </span>
  );
}
